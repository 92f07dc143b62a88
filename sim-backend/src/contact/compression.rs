//! Compliance of the object under one fingertip: spring and damper, integrated implicitly.

/// Damping over stiffness, s (prototype).
const DAMPING_S: f64 = 0.005;
/// Recovery time constant of an untouched object, s (prototype).
const RECOVERY_S: f64 = 0.05;
/// Newton step below which the solution has converged, m: far below the 1 mN of one bristle.
const STEP_MIN_M: f64 = 1e-10;
/// Limit of Newton steps. The residual is concave and piecewise linear; three steps usually
/// suffice.
const STEPS_MAX: usize = 8;

#[derive(Clone, Debug, Default)]
pub(super) struct Compression {
    pub(super) depth_m: f64,
}

impl Compression {
    pub(super) fn recover(&mut self, dt_s: f64) {
        self.depth_m -= self.depth_m * (dt_s / RECOVERY_S);
    }

    /// Sets the compression of a rigid object to zero.
    pub(super) fn clear(&mut self) {
        self.depth_m = 0.0;
    }

    /// Integrates one implicit step of c·du/dt + k·u = bristle force at indentation − u.
    pub(super) fn step(&mut self, depths_m: &[f64], bristle_n_m: f64, object_n_m: f64, dt_s: f64) {
        let before_m = self.depth_m;
        let damping_n_m = object_n_m * (DAMPING_S / dt_s);
        for _ in 0..STEPS_MAX {
            let u = self.depth_m;
            let (mut force_n, mut slope_n_m) = (0.0, 0.0);
            for depth_m in depths_m.iter().filter(|depth_m| **depth_m > u) {
                force_n += bristle_n_m * (depth_m - u);
                slope_n_m += bristle_n_m;
            }
            let residual_n = damping_n_m * (u - before_m) + object_n_m * u - force_n;
            let step_m = residual_n / (damping_n_m + object_n_m + slope_n_m);
            self.depth_m = u - step_m;
            if step_m.abs() < STEP_MIN_M {
                break;
            }
        }
    }
}
