//! Contact of one fingertip with one object: a bed of elasto-plastic bristles.
//!
//! The skin is a Winkler foundation: every bristle presses along the object's normal with its own indentation and its
//! own damping. Along the surface each bristle is an elastic rod that drags until friction holds no more (return map),
//! so single bristles slip before the whole fingertip does, and incipient slip is visible in the element forces.
//! The object's own softness is one compression per contact, solved implicitly.
//!
//! A bristle's shear is kept in the object's frame and forgotten when the bristle lifts off. Everything here is in the
//! object's frame: origin in the middle of its shape.

use nalgebra::{Matrix3, Vector3};

use crate::pad::Pad;
use crate::shape::Shape;
use bristle::{Bristle, Rub};
use compression::Compression;

mod bristle;
mod compression;

/// Damping time of the skin, across and along the surface: its damping is this times its stiffness, s (prototype).
const SKIN_DAMPING_S: f64 = 0.002;
/// Most of a light object's momentum that the damping of one fingertip may take in one step. Ours: the prototype has no
/// bound, and an object of 12 g squeezed with 8 N explodes; it binds below 30 g at 1 N and below 80 g at 8 N.
const DAMPING_SHARE: f64 = 0.1;
/// Shear stiffness over normal stiffness of a bristle (prototype; Mindlin gives 0.7 to 1 for rubber on a hard flat).
const SHEAR_STIFFNESS_RATIO: f64 = 0.7;
/// A fingertip that was free this long begins a new grasp: its slip counts from zero again, s. Ours.
const REGRASP_S: f64 = 0.05;
/// What a fingertip meets on an object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    pub(crate) shape: Shape,
    /// Static friction coefficient.
    pub(crate) friction: f64,
    pub(crate) mass_kg: f64,
    /// Stiffness under one fingertip, N/m; infinite for a rigid object.
    pub(crate) stiffness_n_m: f64,
}

/// Where a fingertip is and how it moves, seen from the object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Approach {
    /// The tip's axes in the object's frame.
    pub(crate) object_from_tip: Matrix3<f64>,
    /// The tip frame's origin, m.
    pub(crate) centre_m: Vector3<f64>,
    /// Velocity against the object of the tip's point that is at the object's origin, m/s.
    pub(crate) velocity_m_s: Vector3<f64>,
    /// Angular velocity against the object, rad/s.
    pub(crate) angular_rad_s: Vector3<f64>,
}

/// Force and moment about the middle of the object, object frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Wrench {
    pub(crate) force_n: Vector3<f64>,
    pub(crate) moment_n_m: Vector3<f64>,
}

/// A bristle that touches in this step.
#[derive(Clone, Copy, Debug)]
struct Touch {
    bristle: usize,
    depth_m: f64,
    point_m: Vector3<f64>,
    normal: Vector3<f64>,
    /// Force on the object, object frame.
    force_n: Vector3<f64>,
}

/// The contact of one fingertip: its bristles' memory and what it last felt.
#[derive(Clone, Debug)]
pub(crate) struct Contact {
    /// Each bristle's memory, and the step in which it last touched.
    bristles: Vec<(Bristle, u64)>,
    touches: Vec<Touch>,
    step: u64,
    compression: Compression,
    object_from_tip: Matrix3<f64>,
    free_s: f64,
    /// Sum of the bristles' normal forces, N.
    pub(crate) normal_n: f64,
    /// Distance slid since the present grasp's first touch, weighted by normal force, m.
    pub(crate) slip_m: f64,
    /// Share of the normal force under bristles that slide now, 0 to 1: 1 when the fingertip slips as a whole.
    pub(crate) sliding_share: f64,
}

impl Contact {
    /// Of a fingertip with this skin.
    pub(crate) fn new(pad: &Pad) -> Self {
        Self {
            bristles: vec![(Bristle::default(), 0); pad.count()],
            touches: Vec::with_capacity(pad.count()),
            step: 1,
            compression: Compression::default(),
            object_from_tip: Matrix3::identity(),
            free_s: 0.0,
            normal_n: 0.0,
            slip_m: 0.0,
            sliding_share: 0.0,
        }
    }

    /// Makes every bristle forget its shear.
    pub(crate) fn let_go(&mut self) {
        self.step += 1;
    }

    /// One step of `dt_s` with nothing in reach.
    pub(crate) fn free(&mut self, dt_s: f64) {
        self.let_go();
        self.touches.clear();
        self.free_s += dt_s;
        self.compression.recover(dt_s);
        self.normal_n = 0.0;
        self.sliding_share = 0.0;
    }

    /// One step of `dt_s` against a surface; returns the wrench on the object.
    pub(crate) fn press(
        &mut self,
        pad: &Pad,
        surface: &Surface,
        approach: &Approach,
        dt_s: f64,
    ) -> Wrench {
        self.find_touches(pad, &surface.shape, approach);
        if self.touches.is_empty() {
            self.free(dt_s);
            return Wrench::default();
        }
        self.step += 1;
        if self.free_s >= REGRASP_S {
            self.slip_m = 0.0;
        }
        self.free_s = 0.0;
        self.object_from_tip = approach.object_from_tip;
        self.give_way(pad, surface, dt_s);
        self.drag(pad, surface, approach, dt_s)
    }

    /// Collects the bristles under the surface: all against the supporting plane first, then those few exactly.
    fn find_touches(&mut self, pad: &Pad, shape: &Shape, approach: &Approach) {
        self.touches.clear();
        let face = shape.face_towards(&approach.centre_m);
        let gap_m = face.normal.dot(&approach.centre_m) - face.offset_m;
        if gap_m >= pad.reach_m {
            return;
        }
        let normal_in_tip = approach.object_from_tip.tr_mul(&face.normal);
        let touches = &mut self.touches;
        pad.below_plane(&normal_in_tip, gap_m, |bristle, over_reach| {
            let arm_m = approach.object_from_tip * over_reach * pad.reach_m;
            let point_m = approach.centre_m + arm_m;
            if let Some((depth_m, normal)) = face
                .depth_at(&point_m)
                .filter(|(depth_m, _)| *depth_m > 0.0)
            {
                let force_n = Vector3::zeros();
                touches.push(Touch {
                    bristle,
                    depth_m,
                    point_m,
                    normal,
                    force_n,
                });
            }
        });
    }

    /// Lets the object give way, and forgets the bristles that no longer press.
    fn give_way(&mut self, pad: &Pad, surface: &Surface, dt_s: f64) {
        let depths_m = self.touches.iter().map(|touch| touch.depth_m);
        self.compression
            .step(depths_m, pad.stiffness_n_m, surface.stiffness_n_m, dt_s);
        let compression_m = self.compression.depth_m;
        if compression_m == 0.0 {
            return;
        }
        self.touches.retain_mut(|touch| {
            touch.depth_m -= compression_m;
            touch.depth_m > 0.0
        });
    }

    /// Normal and friction force of every touching bristle, and their sum.
    fn drag(&mut self, pad: &Pad, surface: &Surface, approach: &Approach, dt_s: f64) -> Wrench {
        let bristle_n_m = pad.stiffness_n_m;
        let skin_n_m = bristle_n_m * self.touches.len() as f64;
        let damping_s = SKIN_DAMPING_S.min(DAMPING_SHARE * surface.mass_kg / (dt_s * skin_n_m));
        let mut sum = Wrench::default();
        let (mut normal_n, mut slid_n_m, mut sliding_n) = (0.0, 0.0, 0.0);
        for touch in &mut self.touches {
            let (velocity, leaving_m_s) = approach.velocity_at(touch);
            let pressing_n = (bristle_n_m * (touch.depth_m - damping_s * leaving_m_s)).max(0.0);
            let (bristle, touched_in) = &mut self.bristles[touch.bristle];
            let is_fresh = *touched_in + 1 != self.step;
            let before = if is_fresh {
                Bristle::default()
            } else {
                *bristle
            };
            let rubbed = before.rubbed(&Rub {
                normal: touch.normal,
                sliding_m_s: velocity - touch.normal * leaving_m_s,
                shear_n_m: bristle_n_m * SHEAR_STIFFNESS_RATIO,
                damping_s,
                limit_n: surface.friction * pressing_n,
                dt_s,
            });
            (*bristle, *touched_in) = (rubbed.bristle, self.step);
            touch.force_n = rubbed.force_n - touch.normal * pressing_n;
            normal_n += pressing_n;
            slid_n_m += pressing_n * rubbed.slid_m;
            sliding_n += if rubbed.slid_m > 0.0 { pressing_n } else { 0.0 };
            sum.force_n += touch.force_n;
            sum.moment_n_m += touch.point_m.cross(&touch.force_n);
        }
        self.normal_n = normal_n;
        if normal_n > 0.0 {
            self.slip_m += slid_n_m / normal_n;
            self.sliding_share = sliding_n / normal_n;
        }
        sum
    }

    /// Adds up the force of the object on the tip per element, tip frame, N.
    pub(crate) fn element_forces(&self, pad: &Pad, force_n: &mut [Vector3<f64>]) {
        force_n.fill(Vector3::zeros());
        for touch in &self.touches {
            force_n[pad.element_of(touch.bristle)] -= touch.force_n;
        }
        if !self.touches.is_empty() {
            for force in force_n {
                *force = self.object_from_tip.tr_mul(force);
            }
        }
    }

    /// Whether any bristle presses.
    pub(crate) fn is_touching(&self) -> bool {
        self.normal_n > 0.0
    }
}

impl Approach {
    /// Velocity of the skin against the object where a bristle touches, and its share along the outward normal, m/s.
    #[inline]
    fn velocity_at(&self, touch: &Touch) -> (Vector3<f64>, f64) {
        let velocity = self.velocity_m_s + self.angular_rad_s.cross(&touch.point_m);
        (velocity, velocity.dot(&touch.normal))
    }
}

#[cfg(test)]
mod tests;
