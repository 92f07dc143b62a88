//! Threaded cap on the neck of its bottle.
//!
//! ```text
//!              rests on the rim, within 2 mm and 5°
//!   loose ───────────────────────────────────▶ engaged: turns on the neck, travels by its pitch
//!   (free body) ◀────────────────────────────  (one degree of freedom)
//!              pulled up before the first turn
//! ```
//!
//! An engaged cap has one degree of freedom, its angle on the thread. The bottle receives every
//! load on the cap, with the axial torque limited to the thread's torque. The initial offset from
//! the axis shrinks to zero over the first quarter turn.

use core::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use crate::body::{Body, Motion, quaternion_about_z, quaternion_product, rotated};
use crate::contact::Wrench;
use crate::object::{Neck, Object};
use crate::scene::{Mount, Placed};
use crate::support::Rim;
use crate::thread::{CapTruth, Thread, ThreadState};
use crate::world_object::WorldObject;

/// Largest offset from the axis at which a cap engages, m (task specification).
const CAPTURE_M: f64 = 0.002;
/// Largest tilt at which a cap engages, rad (5°, task specification).
const CAPTURE_TILT_RAD: f64 = 0.087;
/// Share of the cap's weight that must rest on the rim to engage. Design choice: shows that the cap
/// was put down.
const CAPTURE_WEIGHT: f64 = 0.5;
/// Margin of the rim beyond the cap's radius, m. Design choice: a cap just outside the capture
/// range still rests on the rim; a tilted one falls off.
const RIM_MARGIN_M: f64 = 0.003;
/// Turn over which the thread centres the cap, rad. Design choice.
const CENTRING_RAD: f64 = FRAC_PI_2;
/// Turn below which a pull removes the cap, rad. Design choice.
const LOOSE_RAD: f64 = 0.02;

/// Cap and bottle, as indices into the scene's objects.
#[derive(Clone, Debug)]
pub(crate) struct ThreadedCap {
    cap: usize,
    bottle: usize,
    thread: Thread,
    /// Height of the rim above the bottle's middle, m.
    rim_m: f64,
    cap_half_m: f64,
    cap_radius_m: f64,
    engaged: Option<Engaged>,
}

/// State of an engaged cap relative to its bottle.
#[derive(Clone, Copy, Debug)]
struct Engaged {
    turning: ThreadState,
    /// Yaw about the bottle's axis at engagement, rad.
    yaw_rad: f64,
    /// Offset from the engaged position at engagement, bottle frame, m.
    offset_m: Vector3<f64>,
    /// Tilt at engagement, rotation vector in the bottle frame, rad.
    tilt_rad: Vector3<f64>,
}

impl ThreadedCap {
    /// Returns the cap and bottle of a scene, if it has both.
    pub(crate) fn from_scene(scene: &[Placed]) -> Option<Self> {
        let find = |is: fn(&Object) -> bool| scene.iter().position(|placed| is(&placed.object));
        let (cap, bottle) = (
            find(|object| object.thread.is_some())?,
            find(|object| object.neck.is_some())?,
        );
        let (cap_object, bottle_object) = (&scene[cap].object, &scene[bottle].object);
        let Neck { rim_m } = bottle_object.neck?;
        let on_neck = scene[cap].mount == Mount::OnNeck;
        Some(Self {
            cap,
            bottle,
            thread: cap_object.thread?,
            rim_m: rim_m - bottle_object.shape.half_height_m(),
            cap_half_m: cap_object.shape.half_height_m(),
            cap_radius_m: cap_object.shape.width_m() / 2.0,
            engaged: on_neck.then(|| Engaged::aligned(scene[cap].yaw_rad)),
        })
    }

    pub(crate) fn initialise(&mut self, objects: &mut [WorldObject], dt_s: f64) {
        if self.engaged.is_some() {
            self.update(objects, dt_s);
            objects[self.cap].set_start_position();
        }
    }

    /// Returns the rim that supports a loose cap; `None` for other objects and an engaged cap.
    pub(crate) fn rim_for(&self, index: usize, objects: &[WorldObject]) -> Option<Rim> {
        (index == self.cap && self.engaged.is_none()).then(|| self.rim(&objects[self.bottle].body))
    }

    /// Returns true if the thread determines the motion of this object.
    pub(crate) fn constrains(&self, index: usize) -> bool {
        index == self.cap && self.engaged.is_some()
    }

    /// Integrates the angle of an engaged cap and passes its load to the bottle. Call before the
    /// bodies move.
    pub(crate) fn apply_load(&mut self, objects: &mut [WorldObject], dt_s: f64) {
        let Some(engaged) = &mut self.engaged else {
            return;
        };
        let cap_load = objects[self.cap].body.take_load();
        let axis = objects[self.bottle]
            .body
            .base_from_body
            .column(2)
            .into_owned();
        if engaged.turning.angle_rad < LOOSE_RAD && cap_load.force_n.dot(&axis) > 0.0 {
            self.engaged = None;
            return;
        }
        let about_axis_n_m = cap_load.moment_n_m.dot(&axis);
        let closing = self.thread.closes.sign();
        engaged
            .turning
            .step(&self.thread, closing * about_axis_n_m, dt_s);
        let passed_n_m = closing * engaged.turning.torque_n_m;
        let load = Wrench {
            force_n: cap_load.force_n,
            moment_n_m: cap_load.moment_n_m + axis * (passed_n_m - about_axis_n_m),
        };
        let at_m = objects[self.cap].body.position_m;
        objects[self.bottle].body.apply_at(&at_m, &load);
    }

    /// Moves an engaged cap with its bottle, or engages a loose one. Call after the bodies have
    /// moved.
    pub(crate) fn update(&mut self, objects: &mut [WorldObject], dt_s: f64) {
        if let Some(engaged) = &self.engaged {
            let motion = self.motion(engaged, &objects[self.bottle].body, dt_s);
            objects[self.cap].body.set_motion(&motion);
            return;
        }
        let rim = self.rim(&objects[self.bottle].body);
        let pressed = objects[self.cap].body.take_rim_load();
        objects[self.bottle].body.apply_at(&rim.centre_m, &pressed);
        self.engaged = self.try_engage(&objects[self.cap].body, &objects[self.bottle].body);
    }

    fn motion(&self, engaged: &Engaged, bottle: &Body, dt_s: f64) -> Motion {
        let ThreadState {
            angle_rad,
            rate_rad_s,
            ..
        } = engaged.turning;
        let local_m = self.centre_m(engaged, angle_rad);
        let before_m = self.centre_m(engaged, angle_rad - rate_rad_s * dt_s);
        let arm_m = bottle.base_from_body * local_m;
        let turning = bottle.base_from_body.column(2) * (self.thread.closes.sign() * rate_rad_s);
        let along = bottle.base_from_body * (local_m - before_m) / dt_s;
        let leaning = rotated(
            [1.0, 0.0, 0.0, 0.0],
            &(engaged.tilt_rad * remaining_share(angle_rad)),
        );
        let yaw = quaternion_about_z(engaged.yaw_rad + self.thread.closes.sign() * angle_rad);
        Motion {
            position_m: bottle.position_m + arm_m,
            orientation: quaternion_product(bottle.orientation(), quaternion_product(leaning, yaw)),
            velocity_m_s: bottle.velocity_m_s + bottle.angular_rad_s.cross(&arm_m) + along,
            angular_rad_s: bottle.angular_rad_s + turning,
        }
    }

    fn centre_m(&self, engaged: &Engaged, angle_rad: f64) -> Vector3<f64> {
        let height_m = self.rim_m + self.cap_half_m - self.thread.travel_m(angle_rad);
        Vector3::z() * height_m + engaged.offset_m * remaining_share(angle_rad)
    }

    fn rim(&self, bottle: &Body) -> Rim {
        let arm_m = bottle.base_from_body.column(2) * self.rim_m;
        Rim {
            centre_m: bottle.position_m + arm_m,
            radius_m: self.cap_radius_m + RIM_MARGIN_M,
            velocity_m_s: bottle.velocity_m_s + bottle.angular_rad_s.cross(&arm_m),
        }
    }

    /// Returns the engaged state if a loose cap is within the capture range.
    fn try_engage(&self, cap: &Body, bottle: &Body) -> Option<Engaged> {
        if cap.rim_n < CAPTURE_WEIGHT * cap.weight_n() {
            return None;
        }
        let bottle_from_cap = bottle.base_from_body.tr_mul(&cap.base_from_body);
        let centre_m = bottle
            .base_from_body
            .tr_mul(&(cap.position_m - bottle.position_m));
        let off_m = centre_m - Vector3::z() * (self.rim_m + self.cap_half_m);
        let upright = bottle_from_cap.column(2);
        let lean_rad = Vector3::z().cross(&upright);
        let centred = off_m.x * off_m.x + off_m.y * off_m.y < CAPTURE_M * CAPTURE_M;
        (centred && upright.z > 0.0 && lean_rad.norm() < CAPTURE_TILT_RAD).then(|| Engaged {
            offset_m: off_m,
            tilt_rad: lean_rad,
            ..Engaged::aligned(libm::atan2(
                bottle_from_cap[(1, 0)],
                bottle_from_cap[(0, 0)],
            ))
        })
    }

    pub(crate) fn truth(&self, index: usize) -> Option<CapTruth> {
        let turning = self
            .engaged
            .map(|engaged| engaged.turning)
            .unwrap_or_default();
        (index == self.cap).then(|| CapTruth {
            engaged: self.engaged.is_some(),
            angle_rad: turning.angle_rad,
            torque_n_m: turning.torque_n_m,
            holding_n_m: self.thread.torque_limit_n_m(turning.slid_rad()),
            thread: self.thread,
        })
    }

    pub(crate) fn is_closed(&self) -> bool {
        self.engaged
            .is_some_and(|engaged| engaged.turning.angle_rad >= self.thread.closing_rad)
    }
}

impl Engaged {
    fn aligned(yaw_rad: f64) -> Self {
        Self {
            turning: ThreadState::default(),
            yaw_rad,
            offset_m: Vector3::zeros(),
            tilt_rad: Vector3::zeros(),
        }
    }
}

/// Returns the share of the initial offset and tilt that remains at an angle.
fn remaining_share(angle_rad: f64) -> f64 {
    (1.0 - angle_rad / CENTRING_RAD).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests;
