//! The thread of a cap: how far it is turned, and the torque that turning takes.
//!
//! Friction is one elastic bristle that drags at a limit; the limit is the thread's friction until the cap meets the
//! neck, and rises from there. It holds in both directions, so that a closed cap stays closed. The law is the
//! prototype's.

/// Rise of the holding torque beyond the closing angle, N·m/rad (tactile design).
const RISE_N_M_RAD: f64 = 0.5;
/// Torsional stiffness of the thread while it holds, N·m/rad (prototype).
const STIFFNESS_N_M_RAD: f64 = 5.0;
/// Viscous damping of the thread, N·m·s/rad (prototype).
const DAMPING_N_M_S_RAD: f64 = 0.004;
/// Inertia of a cap, kg·m² (prototype). A cap of 10 g has a fifth of it; with that the step of 250 µs is unstable. At the
/// angular accelerations of screwing, below 10 rad/s², it stands for less than 0.1 mN·m.
pub(crate) const INERTIA_KG_M2: f64 = 8e-6;

/// Which way a cap closes, seen from above.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Turn {
    /// As a standard right-hand thread does.
    #[default]
    Clockwise,
    /// A left-hand thread.
    Anticlockwise,
}

impl Turn {
    /// Sign of a closing turn about the upward axis.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Clockwise => -1.0,
            Self::Anticlockwise => 1.0,
        }
    }
}

/// What the thread of a cap is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thread {
    /// Friction torque, N·m.
    pub friction_n_m: f64,
    /// Angle from where the threads meet to where the cap is closed, rad.
    pub closing_rad: f64,
    /// Axial travel of one turn, m.
    pub pitch_m: f64,
    /// Which way it closes.
    pub closes: Turn,
}

/// What a judge may know of a cap.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CapTruth {
    pub(crate) engaged: bool,
    pub(crate) angle_rad: f64,
    pub(crate) torque_n_m: f64,
    pub(crate) holding_n_m: f64,
    pub(crate) thread: Thread,
}

impl Thread {
    /// Torque that it takes to turn a cap at this angle any further, N·m.
    #[must_use]
    pub fn holding_n_m(&self, angle_rad: f64) -> f64 {
        self.friction_n_m + RISE_N_M_RAD * (angle_rad - self.closing_rad).max(0.0)
    }

    /// How far a cap at this angle has come down, m. Turning back beyond the beginning lifts nothing.
    #[must_use]
    pub fn travel_m(&self, angle_rad: f64) -> f64 {
        self.pitch_m * angle_rad.max(0.0) / core::f64::consts::TAU
    }
}

/// A cap's way along its thread; positive is closing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Turning {
    pub(crate) angle_rad: f64,
    pub(crate) rate_rad_s: f64,
    /// Elastic twist of the thread, rad.
    twist_rad: f64,
    /// Torque that the thread passed to the neck in the last step, N·m.
    pub(crate) torque_n_m: f64,
}

impl Turning {
    /// One step under a torque on the cap.
    pub(crate) fn step(&mut self, thread: &Thread, drive_n_m: f64, dt_s: f64) {
        let limit_n_m = thread.holding_n_m(self.angle_rad);
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
        closes: Turn::Clockwise,
    };

    /// Angle after so many steps of 250 µs under a torque that rises to its value in half a second.
    fn turned_rad(start_rad: f64, drive_n_m: f64, steps: usize) -> f64 {
        let mut turning = Turning {
            angle_rad: start_rad,
            ..Turning::default()
        };
        for step in 0..steps {
            let share = (step as f64 / 2000.0).min(1.0);
            turning.step(&THREAD, share * drive_n_m, 250e-6);
        }
        turning.angle_rad
    }

    #[test]
    fn a_cap_turns_only_beyond_the_friction_of_its_thread() {
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
    fn a_closed_cap_holds_what_closed_it() {
        for drive_n_m in [0.02, 0.03, 0.05] {
            let mut turning = Turning {
                angle_rad: 2.9,
                ..Turning::default()
            };
            // A drive that slows the cap as fingers do.
            for _ in 0..40_000 {
                turning.step(&THREAD, drive_n_m - 0.05 * turning.rate_rad_s, 250e-6);
            }
            let expected_rad = 3.0 + (drive_n_m - 0.015) / RISE_N_M_RAD;
            assert!(
                (turning.angle_rad - expected_rad).abs() < 0.01,
                "{drive_n_m}: {turning:?}"
            );
            assert!((turning.torque_n_m - drive_n_m).abs() < 1e-4);
            let closed_rad = turning.angle_rad;
            (0..8000).for_each(|_| turning.step(&THREAD, 0.0, 250e-6));
            assert!(
                closed_rad - turning.angle_rad < 0.011,
                "it only springs back"
            );
        }
    }

    #[test]
    fn travel_follows_the_pitch() {
        assert_eq!(THREAD.travel_m(-1.0), 0.0);
        assert!((THREAD.travel_m(core::f64::consts::PI) - 0.0015).abs() < 1e-15);
    }
}
