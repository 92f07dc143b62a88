//! Context of a goal check.

use crate::sensor_setup::SensorSetup;
use crate::settings::Settings;
use crate::tasks::Task;
use robot_model::{HandSide, HandVector, RobotModel, RobotVector};

/// Context that a goal is validated against.
#[derive(Clone, Copy, Debug)]
pub struct GoalContext<'a> {
    /// Robot model.
    pub robot: &'a RobotModel,
    /// Sensor set-up.
    pub wiring: &'a SensorSetup,
    /// Settings in force.
    pub settings: &'a Settings,
    /// User-defined tasks.
    pub tasks: &'a [Task],
    /// Last commanded joint positions, rad or m; without them, paths are not checked.
    pub commanded_position: Option<&'a RobotVector>,
}

impl GoalContext<'_> {
    /// Returns the joint positions of one hand and its arm, rad.
    pub(super) fn hand_position(&self, q: &RobotVector, side: HandSide) -> HandVector {
        HandVector::from_slice(&q[self.robot.joint_range(side)])
    }
}
