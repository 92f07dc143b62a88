//! Cap thread: angle and friction torque.
//!
//! Friction is one elastic bristle with a torque limit. The limit is the thread's friction up to
//! the closing angle and rises beyond it with the tension of the thread. Only sliding tightens the
//! thread, the twist of the bristle does not: a cap that springs back keeps its tension. The limit
//! acts in both directions, therefore a closed cap stays closed. Friction law of the prototype.

/// Rise of the holding torque beyond the closing angle, N·m/rad (tactile design).
pub(crate) const RISE_N_M_RAD: f64 = 0.5;
/// Torsional stiffness of the sticking thread, N·m/rad (prototype).
const STIFFNESS_N_M_RAD: f64 = 5.0;
/// Viscous damping, N·m·s/rad (prototype).
const DAMPING_N_M_S_RAD: f64 = 0.004;
/// Inertia of a cap, kg·m² (prototype). A 10 g cap has a fifth of it, which is unstable at 250 µs.
/// The difference is below 0.1 mN·m at screwing accelerations (below 10 rad/s²).
pub(crate) const INERTIA_KG_M2: f64 = 8e-6;

/// Direction in which a cap closes, seen from above.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClosingDirection {
    /// Right-hand thread.
    #[default]
    Clockwise,
    /// Left-hand thread.
    Anticlockwise,
}

impl ClosingDirection {
    /// Returns the sign of a closing rotation about the upward axis.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Clockwise => -1.0,
            Self::Anticlockwise => 1.0,
        }
    }
}

/// Parameters of a cap's thread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thread {
    /// Friction torque, N·m.
    pub friction_n_m: f64,
    /// Angle from engagement to closed, rad.
    pub closing_rad: f64,
    /// Axial travel per revolution, m.
    pub pitch_m: f64,
    /// Closing direction.
    pub closes: ClosingDirection,
}

/// Ground truth of a cap.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CapTruth {
    pub(crate) engaged: bool,
    pub(crate) angle_rad: f64,
    pub(crate) torque_n_m: f64,
    pub(crate) holding_n_m: f64,
    pub(crate) thread: Thread,
}

impl Thread {
    /// Returns the torque limit of a thread that has slid by an angle, N·m.
    #[must_use]
    pub fn torque_limit_n_m(&self, slid_rad: f64) -> f64 {
        self.friction_n_m + RISE_N_M_RAD * (slid_rad - self.closing_rad).max(0.0)
    }

    /// Returns the downward travel of a cap at an angle, m; zero below zero.
    #[must_use]
    pub fn travel_m(&self, angle_rad: f64) -> f64 {
        self.pitch_m * angle_rad.max(0.0) / core::f64::consts::TAU
    }
}

/// State of a cap on its thread; positive is closing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ThreadState {
    pub(crate) angle_rad: f64,
    pub(crate) rate_rad_s: f64,
    /// Elastic twist, rad.
    twist_rad: f64,
    /// Torque on the neck in the last step, N·m.
    pub(crate) torque_n_m: f64,
}

impl ThreadState {
    /// Returns the angle without the elastic twist, rad.
    pub(crate) fn slid_rad(&self) -> f64 {
        self.angle_rad - self.twist_rad
    }

    /// Advances one step under a torque on the cap.
    pub(crate) fn step(&mut self, thread: &Thread, drive_n_m: f64, dt_s: f64) {
        let limit_n_m = thread.torque_limit_n_m(self.slid_rad());
        let twist_rad = self.twist_rad + self.rate_rad_s * dt_s;
        let trial_n_m = STIFFNESS_N_M_RAD * twist_rad + DAMPING_N_M_S_RAD * self.rate_rad_s;
        let holds = trial_n_m.abs() <= limit_n_m;
        self.torque_n_m = if holds {
            trial_n_m
        } else {
            limit_n_m.copysign(trial_n_m)
        };
        self.twist_rad = if holds {
            twist_rad
        } else {
            self.torque_n_m / STIFFNESS_N_M_RAD
        };
        self.rate_rad_s += (drive_n_m - self.torque_n_m) / INERTIA_KG_M2 * dt_s;
        self.angle_rad += self.rate_rad_s * dt_s;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const THREAD: Thread = Thread {
        friction_n_m: 0.015,
        closing_rad: 3.0,
        pitch_m: 0.003,
        closes: ClosingDirection::Clockwise,
    };

    /// Returns the angle after 250 µs steps under a torque that rises over 0.5 s.
    fn turned_rad(start_rad: f64, drive_n_m: f64, steps: usize) -> f64 {
        let mut turning = ThreadState {
            angle_rad: start_rad,
            ..ThreadState::default()
        };
        for step in 0..steps {
            let share = (step as f64 / 2000.0).min(1.0);
            turning.step(&THREAD, share * drive_n_m, 250e-6);
        }
        turning.angle_rad
    }

    #[test]
    fn cap_turns_only_above_thread_friction() {
        let elastic_rad = 0.015 / STIFFNESS_N_M_RAD;
        for drive_n_m in [0.0, 0.005, 0.0145, -0.0145] {
            let angle_rad = turned_rad(1.0, drive_n_m, 4000) - 1.0;
            assert!(
                angle_rad.abs() <= 1.01 * elastic_rad,
                "{drive_n_m}: {angle_rad}"
            );
        }
        assert!(turned_rad(1.0, 0.016, 4000) > 1.1);
        assert!(turned_rad(1.0, -0.016, 4000) < 0.9);
    }

    #[test]
    fn closed_cap_holds_its_closing_torque() {
        for drive_n_m in [0.02, 0.03, 0.05] {
            let mut turning = ThreadState {
                angle_rad: 2.9,
                ..ThreadState::default()
            };
            // The drive torque falls with speed, like that of fingers.
            for _ in 0..40_000 {
                turning.step(&THREAD, drive_n_m - 0.05 * turning.rate_rad_s, 250e-6);
            }
            let expected_rad = 3.0 + (drive_n_m - 0.015) / RISE_N_M_RAD;
            assert!(
                (turning.slid_rad() - expected_rad).abs() < 0.001,
                "{drive_n_m}: {turning:?}"
            );
            assert!((turning.torque_n_m - drive_n_m).abs() < 1e-4);
            let closed_rad = turning.angle_rad;
            (0..8000).for_each(|_| turning.step(&THREAD, 0.0, 250e-6));
            assert!(
                closed_rad - turning.angle_rad < 0.011,
                "only elastic springback"
            );
            let holding_n_m = THREAD.torque_limit_n_m(turning.slid_rad());
            assert!((holding_n_m - drive_n_m).abs() < 1e-3, "{holding_n_m}");
        }
    }

    #[test]
    fn travel_follows_the_pitch() {
        assert_eq!(THREAD.travel_m(-1.0), 0.0);
        assert!((THREAD.travel_m(core::f64::consts::PI) - 0.0015).abs() < 1e-15);
    }
}
