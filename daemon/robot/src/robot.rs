//! The whole robot: both hands, and its joints in one order.

use core::ops::Range;

use crate::joint::Joint;
use crate::model::HandModel;
use crate::side::Side;
use crate::sizes::{HAND_JOINTS_MAX, ROBOT_JOINTS_MAX, VIRTUAL_FINGERS};
use crate::skin::Skin;

/// The whole robot: left hand, then right hand. Fixed size, no heap.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotModel {
    pub(crate) hands: [HandModel; 2],
}

impl RobotModel {
    /// The arm with hand of one side; one without fingers if the robot has none there.
    #[must_use]
    pub fn hand(&self, side: Side) -> &HandModel {
        &self.hands[side.index()]
    }

    /// The same robot with another skin on the same fingertips.
    #[must_use]
    pub fn with_skin(mut self, skin: Skin) -> Self {
        for hand in &mut self.hands {
            hand.skin = skin;
        }
        self
    }

    /// The sides on which the robot has a hand.
    pub fn sides(&self) -> impl Iterator<Item = Side> + '_ {
        let present = |side: &Side| self.hand(*side).is_present();
        Side::BOTH.into_iter().filter(present)
    }

    /// The hand that acts where nobody says which: the right one if the robot has it.
    #[must_use]
    pub fn acting_side(&self) -> Side {
        self.sides().last().unwrap_or(Side::Right)
    }

    /// How many joints the robot has.
    #[must_use]
    pub fn joint_count(&self) -> usize {
        self.joint_range(Side::Right).end
    }

    /// Positions of one hand's joints in a vector of the whole robot.
    #[must_use]
    pub fn joint_range(&self, side: Side) -> Range<usize> {
        let [left, right] = self.hands.each_ref().map(|hand| hand.joint_count);
        match side {
            Side::Left => 0..left,
            Side::Right => left..left + right,
        }
    }

    /// The joint at a robot index, `None` beyond the last.
    #[must_use]
    pub fn joint(&self, index: usize) -> Option<&Joint> {
        self.joints().nth(index)
    }

    /// All joints in the robot's order.
    pub fn joints(&self) -> impl Iterator<Item = &Joint> {
        self.hands.iter().flat_map(|hand| hand.joints())
    }
}

const _: () = assert!(ROBOT_JOINTS_MAX == 2 * HAND_JOINTS_MAX && VIRTUAL_FINGERS == 2);
