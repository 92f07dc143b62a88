//! Bristle friction: elastic rods that stick up to the friction limit, then slide (elasto-plastic
//! return map).

use crate::lanes::{LANES, LaneSet, Lanes, Row, Rows, Vectors};

/// Kinetic over static friction (prototype).
const KINETIC_FRICTION_RATIO: f64 = 0.9;

#[derive(Clone, Copy, Debug)]
pub(super) struct Bristles {
    /// Shear of each foot relative to its root, object frame, m.
    shear_m: Rows,
    /// Friction ratio per bristle: 1, or the kinetic ratio if it slid in the step before.
    friction_ratio: Row,
}

#[derive(Clone, Copy)]
pub(super) struct FrictionInput<L> {
    /// Outward normal of the surface.
    pub(super) normal: Vectors<L>,
    /// Tangential velocity of the foot, m/s.
    pub(super) sliding_m_s: Vectors<L>,
    /// Friction limit: static friction times normal force, N.
    pub(super) limit_n: L,
}

#[derive(Clone, Copy)]
pub(super) struct BristleParameters<L> {
    /// Shear stiffness, N/m.
    pub(super) shear_n_m: L,
    /// Damping over stiffness of a sticking bristle, s.
    pub(super) damping_s: L,
    pub(super) dt_s: L,
}

#[derive(Clone, Copy)]
pub(super) struct FrictionResult<L> {
    /// Friction force on the object, N.
    pub(super) force_n: Vectors<L>,
    /// Sliding distance, m; zero while sticking.
    pub(super) slid_m: L,
}

impl Default for Bristles {
    fn default() -> Self {
        Self {
            shear_m: [[0.0; LANES]; 3],
            friction_ratio: [1.0; LANES],
        }
    }
}

impl Bristles {
    #[inline(always)]
    pub(super) fn clear_shear(&mut self, fresh: LaneSet) {
        for lane in fresh {
            self.friction_ratio[lane] = 1.0;
            self.shear_m.iter_mut().for_each(|axis| axis[lane] = 0.0);
        }
    }

    /// Computes one step of touching bristles: elastic trial force, reduced to the friction limit.
    /// Other lanes are undefined.
    #[inline(always)]
    pub(super) fn step<L: Lanes>(
        &mut self,
        cpu: L::Cpu,
        touching: LaneSet,
        rub: &FrictionInput<L>,
        rods: &BristleParameters<L>,
    ) -> FrictionResult<L> {
        let before_m = Vectors::load(cpu, &self.shear_m);
        // The object may have rotated under the bristle: only tangential shear remains.
        let along_m = before_m - rub.normal * before_m.dot(rub.normal);
        let shear_m = along_m + rub.sliding_m_s * rods.dt_s;
        let trial_n = (shear_m + rub.sliding_m_s * rods.damping_s) * rods.shear_n_m;
        let limit_n = L::load(cpu, &self.friction_ratio) * rub.limit_n;
        let square_n2 = trial_n.dot(trial_n);
        let sticks = square_n2.at_most(limit_n * limit_n);
        let (one, none) = (L::splat(cpu, 1.0), L::splat(cpu, 0.0));
        if touching.without(L::set(sticks)).is_empty() {
            self.shear_m = shear_m.store();
            self.friction_ratio = one.store();
            return FrictionResult {
                force_n: trial_n,
                slid_m: none,
            };
        }
        let force_n = trial_n * (limit_n / square_n2.sqrt());
        let (slid_m, left_m) = rub.slide(cpu, force_n, limit_n, rods);
        let kinetic = L::splat(cpu, KINETIC_FRICTION_RATIO);
        self.shear_m = Vectors::select(sticks, shear_m, left_m).store();
        self.friction_ratio = L::select(sticks, one, kinetic).store();
        FrictionResult {
            force_n: Vectors::select(sticks, trial_n, force_n),
            slid_m: L::select(sticks, none, slid_m),
        }
    }

    #[cfg(test)]
    pub(super) fn slipping(&self, lane: usize) -> bool {
        self.friction_ratio[lane] < 1.0
    }
}

impl<L: Lanes> FrictionInput<L> {
    /// Returns sliding distance, m, and remaining shear, m, of bristles at the friction limit. The
    /// shear alone gives the limit force, so that damping cannot reverse it when sliding stops.
    #[inline(always)]
    fn slide(
        &self,
        cpu: L::Cpu,
        force_n: Vectors<L>,
        limit_n: L,
        rods: &BristleParameters<L>,
    ) -> (L, Vectors<L>) {
        let speed_m_s = self.sliding_m_s.dot(self.sliding_m_s).sqrt();
        let carried_m = limit_n / rods.shear_n_m;
        let turning_s = carried_m / (speed_m_s + L::splat(cpu, f64::MIN_POSITIVE));
        let damping_s = L::select(turning_s.above(rods.damping_s), rods.damping_s, turning_s);
        let shear_m = force_n / rods.shear_n_m - self.sliding_m_s * damping_s;
        (speed_m_s * rods.dt_s, shear_m)
    }
}
