//! Robot model: both hands, and all joints in one order.

use core::ops::Range;

use crate::joint::Joint;
use crate::model::HandModel;
use crate::side::HandSide;
use crate::sizes::{GRASP_SIDES, HAND_JOINTS_MAX, ROBOT_JOINTS_MAX};
use crate::skin::Skin;

/// Robot model: left hand, then right hand. Fixed size, no heap.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotModel {
    pub(crate) hands: [HandModel; 2],
}

impl RobotModel {
    /// Returns the arm with hand of one side; a hand without fingers if the robot has none there.
    #[must_use]
    pub fn hand(&self, side: HandSide) -> &HandModel {
        &self.hands[side.index()]
    }

    /// Returns the robot with another skin on its fingertips.
    #[must_use]
    pub fn with_skin(mut self, skin: Skin) -> Self {
        for hand in &mut self.hands {
            hand.skin = skin;
        }
        self
    }

    /// Returns the sides on which the robot has a hand.
    pub fn sides(&self) -> impl Iterator<Item = HandSide> + '_ {
        let present = |side: &HandSide| self.hand(*side).is_present();
        HandSide::BOTH.into_iter().filter(present)
    }

    /// Returns the default hand: right if the robot has it, else left.
    #[must_use]
    pub fn acting_side(&self) -> HandSide {
        self.sides().last().unwrap_or(HandSide::Right)
    }

    /// Returns the number of joints.
    #[must_use]
    pub fn joint_count(&self) -> usize {
        self.joint_range(HandSide::Right).end
    }

    /// Returns the index range of one hand's joints in a vector of all joints.
    #[must_use]
    pub fn joint_range(&self, side: HandSide) -> Range<usize> {
        let [left, right] = self.hands.each_ref().map(|hand| hand.joint_count);
        match side {
            HandSide::Left => 0..left,
            HandSide::Right => left..left + right,
        }
    }

    /// Returns the joint at a robot index, `None` beyond the last.
    #[must_use]
    pub fn joint(&self, index: usize) -> Option<&Joint> {
        self.joints().nth(index)
    }

    /// Returns all joints in the robot's order.
    pub fn joints(&self) -> impl Iterator<Item = &Joint> {
        self.hands.iter().flat_map(|hand| hand.joints())
    }
}

const _: () = assert!(ROBOT_JOINTS_MAX == 2 * HAND_JOINTS_MAX && GRASP_SIDES == 2);
