//! Measurements of the grip while the base drives.

use robot_model::GraspSides;
use serde::{Deserialize, Serialize};
use shm_schemas::WorldTruth;

use super::SIDE;
use crate::base_motion::BaseMotion;

/// Accelerations of the base during a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BaseAcceleration {
    /// Largest horizontal acceleration, m/s².
    pub horizontal_m_s2: f64,
    /// Largest vertical acceleration, m/s².
    pub vertical_m_s2: f64,
}

/// Measurements of one drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DriveFigures {
    /// Duration, s.
    pub took_s: f64,
    /// True normal force of the weaker grasp side at the start, N.
    pub began_n: f64,
    /// Smallest value of this force, N.
    pub least_n: f64,
    /// Largest value of this force, N.
    pub most_n: f64,
    /// True slip in the hand during the drive, m.
    pub slip_m: f64,
    /// Accelerations of the base.
    pub shake: BaseAcceleration,
}

/// Drive in progress.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drive {
    figures: DriveFigures,
    sides: GraspSides,
    slip_before_m: f64,
    ticks: u64,
}

impl Drive {
    pub(super) fn begin(truth: &WorldTruth, sides: GraspSides) -> Self {
        let pressed_n = weaker_side_n(truth, sides);
        Self {
            sides,
            figures: DriveFigures {
                began_n: pressed_n,
                least_n: pressed_n,
                most_n: pressed_n,
                ..DriveFigures::default()
            },
            slip_before_m: truth.objects[0].slip_in_hand_m,
            ticks: 0,
        }
    }

    pub(super) fn record(&mut self, truth: &WorldTruth, ride: &BaseMotion) {
        self.ticks += 1;
        let (figures, pressed_n) = (&mut self.figures, weaker_side_n(truth, self.sides));
        figures.least_n = figures.least_n.min(pressed_n);
        figures.most_n = figures.most_n.max(pressed_n);
        figures.slip_m = (truth.objects[0].slip_in_hand_m - self.slip_before_m).max(0.0);
        let shake = &mut figures.shake;
        let aside = ride.speed_m_s * ride.turn_rad_s;
        let horizontal = length(ride.acceleration_m_s2, aside);
        shake.horizontal_m_s2 = shake.horizontal_m_s2.max(horizontal);
        shake.vertical_m_s2 = shake.vertical_m_s2.max(ride.heave_m_s2.abs());
    }

    pub(super) fn figures(&self) -> DriveFigures {
        DriveFigures {
            took_s: self.ticks as f64 * 1e-3,
            ..self.figures
        }
    }
}

/// √(a² + b²), rounded identically on every machine.
fn length(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}

/// Normal force of the weaker grasp side, N.
fn weaker_side_n(truth: &WorldTruth, sides: GraspSides) -> f64 {
    sides.smaller_sum(|fingertip| truth.normal_n[SIDE.index()][fingertip])
}

#[cfg(test)]
mod tests {
    use robot_model::RobotModel;

    use super::*;

    /// Regression: the weaker of the first two fingertips counted as the weaker side.
    #[test]
    fn weaker_side_includes_all_its_fingertips() {
        let mut truth = WorldTruth::default();
        truth.normal_n[SIDE.index()] = [1.0, 1.5, 2.0, 0.0];
        let check = |robot: &str, expected_n: f64| {
            let robot = RobotModel::find(robot).expect("built-in robot");
            let drive = Drive::begin(&truth, robot.hand(SIDE).grasp_sides());
            let figures = drive.figures();
            assert_eq!((figures.began_n, figures.least_n), (expected_n, expected_n));
        };
        check("three-finger", 2.0);
        check("two-hand-arm", 1.0);
    }
}
