//! Disturbances of a held object: loads, bumps of the arm, servos with lag.

use sim_backend::Errors;
use sim_backend::random::Random;

/// Duration of a ramp, s (acceptance criterion).
pub(super) const RAMP_S: f64 = 1.0;
/// Duration of an impulse, s. Design choice: about the reaction time of a hand.
const IMPULSE_S: f64 = 0.05;
/// Duration of a bump, s. Design choice: 5 mm in this time accelerate with 1 g at most.
pub(super) const BUMP_S: f64 = 0.1;
/// Time constant of the lagging servos, s: the default of `--errors servo-lag`.
const SERVO_LAG_S: f64 = 0.02;
/// Random stream of the directions. The value is arbitrary.
const DIRECTION_STREAM: u64 = 0x6469_7265_6374;

/// Disturbance of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Disturbance {
    None,
    /// Force on the object: course, multiple of its weight, direction.
    Load(Course, f64, Direction),
    /// Bump of the arm with this height, m.
    Bump(f64),
    /// Servos with a lag from the start.
    ServoLag,
}

/// Course of a load over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Course {
    Step,
    Ramp,
    Impulse,
}

/// Direction of a load.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    Down,
    Up,
    /// Horizontal, along the closing axis.
    Along,
    /// Horizontal, across the closing axis.
    Across,
    /// Drawn from the seed, uniform on the sphere.
    Any,
}

/// All cases, in the order of the report.
pub(super) const CASES: [Disturbance; 19] = {
    use Course::{Impulse, Ramp, Step};
    use Direction::{Across, Along, Any, Down, Up};
    use Disturbance::{Bump, Load, None, ServoLag};
    [
        None,
        Load(Step, 0.5, Down),
        Load(Step, 1.0, Down),
        Load(Step, 2.0, Down),
        Load(Step, 1.0, Up),
        Load(Step, 2.0, Up),
        Load(Step, 1.0, Across),
        Load(Step, 1.0, Along),
        Load(Step, 1.0, Any),
        Load(Ramp, 0.5, Down),
        Load(Ramp, 1.0, Down),
        Load(Ramp, 2.0, Down),
        Load(Impulse, 0.5, Down),
        Load(Impulse, 1.0, Down),
        Load(Impulse, 2.0, Down),
        Load(Impulse, 2.0, Any),
        Bump(0.005),
        Bump(0.010),
        ServoLag,
    ]
};

impl Course {
    fn name(self) -> &'static str {
        match self {
            Self::Step => "step",
            Self::Ramp => "ramp",
            Self::Impulse => "impulse",
        }
    }

    /// Returns the share of the load at this time since its begin.
    pub(super) fn share(self, since_s: f64) -> f64 {
        match self {
            Self::Step => 1.0,
            Self::Ramp => (since_s / RAMP_S).min(1.0),
            Self::Impulse => f64::from(since_s < IMPULSE_S),
        }
    }
}

impl Direction {
    fn name(self) -> &'static str {
        match self {
            Self::Down => "down",
            Self::Up => "up",
            Self::Along => "along the closing axis",
            Self::Across => "across the closing axis",
            Self::Any => "in any direction",
        }
    }

    /// Returns the unit vector in the base frame.
    pub(super) fn unit(self, closing_yaw_rad: f64, seed: u64) -> [f64; 3] {
        let (sin, cos) = closing_yaw_rad.sin_cos();
        match self {
            Self::Down => [0.0, 0.0, -1.0],
            Self::Up => [0.0, 0.0, 1.0],
            Self::Along => [cos, sin, 0.0],
            Self::Across => [-sin, cos, 0.0],
            Self::Any => {
                let mut random = Random::new(seed, DIRECTION_STREAM);
                let up = random.between(-1.0, 1.0);
                let (sin, cos) = random.between(0.0, core::f64::consts::TAU).sin_cos();
                let flat = (1.0 - up * up).sqrt();
                [flat * cos, flat * sin, up]
            }
        }
    }
}

impl Disturbance {
    /// Returns the name in reports.
    pub(super) fn name(self) -> String {
        match self {
            Self::None => "none".to_owned(),
            Self::Load(course, weights, direction) => {
                format!("{} {weights} × weight {}", course.name(), direction.name())
            }
            Self::Bump(height_m) => format!("bump {} mm in {BUMP_S} s", height_m * 1e3),
            Self::ServoLag => format!("servos with {} ms lag", SERVO_LAG_S * 1e3),
        }
    }

    /// Returns the errors of this case.
    pub(super) fn errors(self) -> Errors {
        Errors {
            servo_lag_s: if self == Self::ServoLag {
                SERVO_LAG_S
            } else {
                0.0
            },
            ..Errors::NONE
        }
    }

    /// Returns height, m, and duration, s, of the bump, if it is one.
    pub(super) fn bump(self) -> Option<[f64; 2]> {
        match self {
            Self::Bump(height_m) => Some([height_m, BUMP_S]),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_unit_vectors_and_seeded() {
        for direction in [
            Direction::Down,
            Direction::Up,
            Direction::Along,
            Direction::Across,
            Direction::Any,
        ] {
            let unit = direction.unit(0.7, 5);
            let square: f64 = unit.iter().map(|axis| axis * axis).sum();
            assert!((square - 1.0).abs() < 1e-12, "{direction:?}");
            assert_eq!(unit, direction.unit(0.7, 5));
        }
        assert_ne!(Direction::Any.unit(0.7, 5), Direction::Any.unit(0.7, 6));
    }

    #[test]
    fn cases_have_unique_names() {
        let mut names = CASES.map(Disturbance::name).to_vec();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), CASES.len());
    }
}
