//! One bristle's friction: an elastic rod that drags until the limit, then slides (elasto-plastic return map).

use nalgebra::Vector3;

/// Kinetic over static friction (prototype).
const KINETIC_FRICTION_RATIO: f64 = 0.9;

/// What a touching bristle remembers from step to step. A fresh one is the default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Bristle {
    /// Shear of its foot against its root, object frame, m.
    shear_m: Vector3<f64>,
    /// Whether it slid in the step before, so that kinetic friction holds.
    pub(super) slipping: bool,
}

/// How a bristle's foot is rubbed in one step.
pub(super) struct Rub {
    /// Outward normal of the surface.
    pub(super) normal: Vector3<f64>,
    /// Velocity of the foot along the surface, m/s.
    pub(super) sliding_m_s: Vector3<f64>,
    /// Shear stiffness, N/m.
    pub(super) shear_n_m: f64,
    /// Damping over stiffness while it sticks, s.
    pub(super) damping_s: f64,
    /// Static friction times normal force, N.
    pub(super) limit_n: f64,
    /// Length of the step, s.
    pub(super) dt_s: f64,
}

/// What came of it.
pub(super) struct Rubbed {
    pub(super) bristle: Bristle,
    /// Friction force on the object, N.
    pub(super) force_n: Vector3<f64>,
    /// Distance slid, m; zero while it sticks.
    pub(super) slid_m: f64,
}

impl Bristle {
    /// The bristle after one step: the elastic trial force, or what friction leaves of it.
    #[inline]
    pub(super) fn rubbed(self, rub: &Rub) -> Rubbed {
        // The object may have turned under the bristle: only the shear along the surface stays.
        let along_m = self.shear_m - rub.normal * self.shear_m.dot(&rub.normal);
        let shear_m = along_m + rub.sliding_m_s * rub.dt_s;
        let trial_n = (shear_m + rub.sliding_m_s * rub.damping_s) * rub.shear_n_m;
        let ratio = if self.slipping {
            KINETIC_FRICTION_RATIO
        } else {
            1.0
        };
        let limit_n = ratio * rub.limit_n;
        let square_n2 = trial_n.dot(&trial_n);
        if square_n2 <= limit_n * limit_n {
            let bristle = Self {
                shear_m,
                slipping: false,
            };
            return Rubbed {
                bristle,
                force_n: trial_n,
                slid_m: 0.0,
            };
        }
        rub.slide(trial_n * (limit_n / square_n2.sqrt()), limit_n)
    }
}

impl Rub {
    /// A sliding bristle under its limiting force: its shear is what will carry that force once the sliding stops, and no
    /// damping turns it round.
    #[inline]
    fn slide(&self, force_n: Vector3<f64>, limit_n: f64) -> Rubbed {
        let speed_m_s = self.sliding_m_s.dot(&self.sliding_m_s).sqrt();
        let carried_m = limit_n / self.shear_n_m;
        let damping_s = self
            .damping_s
            .min(carried_m / (speed_m_s + f64::MIN_POSITIVE));
        let shear_m = force_n / self.shear_n_m - self.sliding_m_s * damping_s;
        let bristle = Bristle {
            shear_m,
            slipping: true,
        };
        Rubbed {
            bristle,
            force_n,
            slid_m: speed_m_s * self.dt_s,
        }
    }
}
