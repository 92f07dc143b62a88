//! Contact of one fingertip with one object: a bed of elasto-plastic bristles.
//!
//! The skin is a Winkler foundation: each bristle presses along the object's normal with its own
//! indentation and damping. Tangentially it is an elastic rod that sticks up to the friction limit,
//! then slides (return map). Single bristles slip before the whole fingertip: incipient slip is
//! visible in the element forces. The object's compliance is one implicit compression per contact.
//!
//! Quantities are in the object's frame: origin in the middle of its shape. A bristle's shear is
//! stored there and cleared at lift-off.

use nalgebra::{Matrix3, Vector3};

#[cfg(target_arch = "x86_64")]
use crate::lanes::avx2;
use crate::lanes::{LANES, LaneSet, Lanes, Row, Rows, Vectors, portable, vector};
use crate::pad::Pad;
use crate::shape::Shape;
use bristle::{BristleParameters, Bristles, FrictionInput, FrictionResult};
use compression::Compression;

mod bristle;
mod compression;

/// Damping over stiffness of the skin, normal and tangential, s (prototype).
const SKIN_DAMPING_S: f64 = 0.002;
/// Largest share of a light object's momentum that one fingertip's damping may remove per step.
/// Design choice: without a bound, an object of 12 g squeezed with 8 N becomes unstable. The bound
/// acts below 30 g at 1 N and below 80 g at 8 N.
const DAMPING_SHARE: f64 = 0.1;
/// Shear over normal stiffness of a bristle (prototype; Mindlin gives 0.7 to 1 for rubber on a
/// flat).
const SHEAR_STIFFNESS_RATIO: f64 = 0.7;
/// Time without contact after which slip counts from zero, s. Design choice.
const REGRASP_S: f64 = 0.05;
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    pub(crate) shape: Shape,
    pub(crate) friction: f64,
    pub(crate) mass_kg: f64,
    /// Stiffness under one fingertip, N/m; infinite for a rigid object.
    pub(crate) stiffness_n_m: f64,
}

/// Pose and velocity of a fingertip in the object's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Approach {
    /// Axes of the tip in the object's frame.
    pub(crate) object_from_tip: Matrix3<f64>,
    /// Origin of the tip frame, m.
    pub(crate) centre_m: Vector3<f64>,
    /// Relative velocity of the tip's point at the object's origin, m/s.
    pub(crate) velocity_m_s: Vector3<f64>,
    /// Relative angular velocity, rad/s or m/s.
    pub(crate) angular_rad_s: Vector3<f64>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Wrench {
    pub(crate) force_n: Vector3<f64>,
    pub(crate) moment_n_m: Vector3<f64>,
}

/// Block of bristles, some of which touch in this step.
#[derive(Clone, Copy, Debug)]
struct Patch {
    block: usize,
    touching: LaneSet,
    depth_m: Row,
    point_m: Rows,
    normal: Rows,
    force_n: Rows,
}

/// Bristle state of a block, the bristles that touched last, and the step in which they did.
#[derive(Clone, Copy, Debug, Default)]
struct BlockState {
    bristles: Bristles,
    touched: LaneSet,
    touched_in: u64,
}

/// Contact state of one fingertip and its latest forces.
#[derive(Clone, Debug)]
pub(crate) struct Contact {
    block_states: Vec<BlockState>,
    patches: Vec<Patch>,
    /// Indentation of every touching bristle, m; used if the object is compressible.
    depths_m: Vec<f64>,
    step: u64,
    compression: Compression,
    object_from_tip: Matrix3<f64>,
    free_s: f64,
    /// Sum of the bristles' normal forces, N.
    pub(crate) normal_n: f64,
    /// Sliding distance since the first touch of this grasp, weighted by normal force, m.
    pub(crate) slip_m: f64,
    /// Share of the normal force on sliding bristles, 0 to 1; 1 is gross slip.
    pub(crate) sliding_share: f64,
}

impl Contact {
    pub(crate) fn new(pad: &Pad) -> Self {
        Self {
            block_states: vec![BlockState::default(); pad.blocks.len()],
            patches: Vec::with_capacity(pad.blocks.len()),
            depths_m: Vec::with_capacity(pad.blocks.len() * LANES),
            step: 1,
            compression: Compression::default(),
            object_from_tip: Matrix3::identity(),
            free_s: 0.0,
            normal_n: 0.0,
            slip_m: 0.0,
            sliding_share: 0.0,
        }
    }

    /// Clears the shear of all bristles.
    pub(crate) fn clear_shear(&mut self) {
        self.step += 1;
    }

    /// Simulates one step of `dt_s` without an object in reach.
    pub(crate) fn step_free(&mut self, dt_s: f64) {
        self.clear_shear();
        self.patches.clear();
        self.free_s += dt_s;
        self.compression.recover(dt_s);
        self.normal_n = 0.0;
        self.sliding_share = 0.0;
    }

    /// Simulates one step of `dt_s` against a surface; returns the wrench on the object.
    pub(crate) fn press(
        &mut self,
        pad: &Pad,
        surface: &Surface,
        approach: &Approach,
        dt_s: f64,
    ) -> Wrench {
        #[cfg(target_arch = "x86_64")]
        if let Some(cpu) = avx2::Cpu::detect() {
            #[expect(unsafe_code, reason = "AVX2 is not available on every x86-64 machine")]
            // SAFETY: this machine has AVX2.
            return unsafe { self.press_avx2(cpu, pad, surface, approach, dt_s) };
        }
        self.press_in::<portable::Numbers>((), pad, surface, approach, dt_s)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn press_avx2(
        &mut self,
        cpu: avx2::Cpu,
        pad: &Pad,
        surface: &Surface,
        approach: &Approach,
        dt_s: f64,
    ) -> Wrench {
        self.press_in::<avx2::Numbers>(cpu, pad, surface, approach, dt_s)
    }

    #[inline(always)]
    fn press_in<L: Lanes>(
        &mut self,
        cpu: L::Cpu,
        pad: &Pad,
        surface: &Surface,
        approach: &Approach,
        dt_s: f64,
    ) -> Wrench {
        self.find_touches::<L>(cpu, pad, &surface.shape, approach);
        if self.patches.is_empty() {
            self.step_free(dt_s);
            return Wrench::default();
        }
        self.step += 1;
        if self.free_s >= REGRASP_S {
            self.slip_m = 0.0;
        }
        self.free_s = 0.0;
        self.object_from_tip = approach.object_from_tip;
        self.compress_object::<L>(cpu, pad, surface, dt_s);
        self.compute_forces::<L>(cpu, pad, surface, approach, dt_s)
    }

    /// Collects the bristles under the surface: all against the supporting plane first, then the
    /// candidates exactly.
    #[inline(always)]
    fn find_touches<L: Lanes>(
        &mut self,
        cpu: L::Cpu,
        pad: &Pad,
        shape: &Shape,
        approach: &Approach,
    ) {
        self.patches.clear();
        let face = shape.face_towards(&approach.centre_m);
        let gap_m = face.normal.dot(&approach.centre_m) - face.offset_m;
        if gap_m >= pad.reach_m {
            return;
        }
        let inward_m = approach.object_from_tip.tr_mul(&face.normal) * -pad.reach_m;
        let (inward_m, gap_m) = (Vectors::splat(cpu, &inward_m), L::splat(cpu, gap_m));
        let centre_m = Vectors::splat(cpu, &approach.centre_m);
        let (reach_m, none_m) = (L::splat(cpu, pad.reach_m), L::splat(cpu, 0.0));
        for (block, over_reach) in pad.blocks.iter().enumerate() {
            let over_reach = Vectors::<L>::load(cpu, over_reach);
            let below = L::set((over_reach.dot(inward_m) - gap_m).above(none_m));
            if below.is_empty() {
                continue;
            }
            let arm_m = over_reach.rotated(cpu, &approach.object_from_tip) * reach_m;
            let point_m = centre_m + arm_m;
            let (depth_m, normal) = face.under(cpu, point_m);
            let touching = L::set(depth_m.above(none_m)).union(below);
            if !touching.is_empty() {
                self.patches.push(Patch {
                    block,
                    touching,
                    depth_m: depth_m.store(),
                    point_m: point_m.store(),
                    normal: normal.store(),
                    force_n: Rows::default(),
                });
            }
        }
    }

    /// Computes the object's compression, and clears the bristles that no longer press.
    #[inline(always)]
    fn compress_object<L: Lanes>(&mut self, cpu: L::Cpu, pad: &Pad, surface: &Surface, dt_s: f64) {
        if surface.stiffness_n_m.is_infinite() {
            return self.compression.clear();
        }
        self.depths_m.clear();
        for patch in &self.patches {
            for lane in patch.touching {
                self.depths_m.push(patch.depth_m[lane]);
            }
        }
        self.compression.step(
            &self.depths_m,
            pad.stiffness_n_m,
            surface.stiffness_n_m,
            dt_s,
        );
        if self.compression.depth_m == 0.0 {
            return;
        }
        let compression_m = L::splat(cpu, self.compression.depth_m);
        let none_m = L::splat(cpu, 0.0);
        for patch in &mut self.patches {
            let depth_m = L::load(cpu, &patch.depth_m) - compression_m;
            patch.depth_m = depth_m.store();
            patch.touching = patch.touching.union(L::set(depth_m.above(none_m)));
        }
    }

    /// Computes normal and friction forces of touching bristles, and their sum.
    #[inline(always)]
    fn compute_forces<L: Lanes>(
        &mut self,
        cpu: L::Cpu,
        pad: &Pad,
        surface: &Surface,
        approach: &Approach,
        dt_s: f64,
    ) -> Wrench {
        let count: u32 = self.patches.iter().map(|patch| patch.touching.len()).sum();
        let skin_n_m = pad.stiffness_n_m * f64::from(count);
        let damping_s = SKIN_DAMPING_S.min(DAMPING_SHARE * surface.mass_kg / (dt_s * skin_n_m));
        let number = |value| L::splat(cpu, value);
        let rods = BristleParameters {
            shear_n_m: number(pad.stiffness_n_m * SHEAR_STIFFNESS_RATIO),
            damping_s: number(damping_s),
            dt_s: number(dt_s),
        };
        let (bristle_n_m, friction) = (number(pad.stiffness_n_m), number(surface.friction));
        let velocity_m_s = Vectors::splat(cpu, &approach.velocity_m_s);
        let angular_rad_s = Vectors::splat(cpu, &approach.angular_rad_s);
        let mut sum = Wrench::default();
        let (mut normal_n, mut slid_n_m, mut sliding_n) = (0.0, 0.0, 0.0);
        for patch in &mut self.patches {
            let point_m = Vectors::<L>::load(cpu, &patch.point_m);
            let normal = Vectors::load(cpu, &patch.normal);
            let velocity = velocity_m_s + angular_rad_s.cross(point_m);
            let leaving_m_s = velocity.dot(normal);
            let depth_m = L::load(cpu, &patch.depth_m);
            let spring_n = bristle_n_m * (depth_m - rods.damping_s * leaving_m_s);
            let none_n = number(0.0);
            let pressing_n = L::select(spring_n.above(none_n), spring_n, none_n);
            let rub = FrictionInput {
                normal,
                sliding_m_s: velocity - normal * leaving_m_s,
                limit_n: friction * pressing_n,
            };
            let memory = &mut self.block_states[patch.block];
            let rubbed = memory.update_friction(cpu, self.step, patch.touching, &rub, &rods);
            let force_n = rubbed.force_n - normal * pressing_n;
            patch.force_n = force_n.store();
            let moment_n_m = point_m.cross(force_n).store();
            let (pressing_n, slid_m) = (pressing_n.store(), rubbed.slid_m.store());
            for lane in patch.touching {
                let (pressing_n, slid_m) = (pressing_n[lane], slid_m[lane]);
                normal_n += pressing_n;
                slid_n_m += pressing_n * slid_m;
                sliding_n += if slid_m > 0.0 { pressing_n } else { 0.0 };
                sum.force_n += vector(&patch.force_n, lane);
                sum.moment_n_m += vector(&moment_n_m, lane);
            }
        }
        self.normal_n = normal_n;
        if normal_n > 0.0 {
            self.slip_m += slid_n_m / normal_n;
            self.sliding_share = sliding_n / normal_n;
        }
        sum
    }

    /// Sums the forces of the object on the tip per element, tip frame, N.
    pub(crate) fn element_forces(&self, pad: &Pad, force_n: &mut [Vector3<f64>]) {
        force_n.fill(Vector3::zeros());
        for patch in &self.patches {
            for lane in patch.touching {
                let element = pad.element_of(patch.block, lane);
                force_n[element] -= vector(&patch.force_n, lane);
            }
        }
        if !self.patches.is_empty() {
            for force in force_n {
                *force = self.object_from_tip.tr_mul(force);
            }
        }
    }

    pub(crate) fn is_touching(&self) -> bool {
        self.normal_n > 0.0
    }
}

impl BlockState {
    /// Updates friction of touching bristles; newly touching ones start without shear.
    #[inline(always)]
    fn update_friction<L: Lanes>(
        &mut self,
        cpu: L::Cpu,
        step: u64,
        touching: LaneSet,
        rub: &FrictionInput<L>,
        rods: &BristleParameters<L>,
    ) -> FrictionResult<L> {
        let known = if self.touched_in + 1 == step {
            self.touched
        } else {
            LaneSet::default()
        };
        self.bristles.clear_shear(touching.without(known));
        (self.touched, self.touched_in) = (touching, step);
        self.bristles.step(cpu, touching, rub, rods)
    }
}

#[cfg(test)]
mod tests;
