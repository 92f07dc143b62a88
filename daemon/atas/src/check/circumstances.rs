//! What a goal is checked against.

use crate::settings::Settings;
use crate::tasks::Task;
use crate::wiring::Wiring;
use robot_model::{HandVector, RobotModel, RobotVector, Side};

/// What a goal is checked against.
#[derive(Clone, Copy, Debug)]
pub struct Circumstances<'a> {
    /// The robot.
    pub robot: &'a RobotModel,
    /// Its sensors.
    pub wiring: &'a Wiring,
    /// The numbers in force: how far the hand opens, how high it comes from.
    pub settings: &'a Settings,
    /// The user's own tasks.
    pub tasks: &'a [Task],
    /// Where the joints were commanded last, rad; `None` before the first command: ways are not checked then.
    pub commanded_rad: Option<&'a RobotVector>,
}

impl Circumstances<'_> {
    /// One hand's share of all joints, rad.
    pub(super) fn hand_rad(&self, q_rad: &RobotVector, side: Side) -> HandVector {
        HandVector::from_slice(&q_rad[self.robot.joint_range(side)])
    }
}
