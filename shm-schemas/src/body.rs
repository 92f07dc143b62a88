//! Names of the robot's bodies: what a [`crate::Reason`] says about two that would collide.

use crate::stamp::Hand;
use core::fmt;

/// Names of the bodies of one arm with its hand, by the joint that moves them (robot design).
const NAMES: [&str; 11] = [
    "shoulder",
    "upper arm",
    "forearm",
    "wrist",
    "palm",
    "finger 1 at its root",
    "finger 1 at its middle",
    "fingertip 1",
    "finger 2 at its root",
    "finger 2 at its middle",
    "fingertip 2",
];

/// One body of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Body {
    /// 0 left, 1 right.
    pub hand: usize,
    /// The joint of that hand that moves it, 0–10.
    pub joint: usize,
}

/// Two bodies as the index of a [`crate::Reason`]; 0 stands for none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyPair(pub [Body; 2]);

impl BodyPair {
    /// The index that stands for the pair.
    #[must_use]
    pub fn index(self) -> usize {
        let [first, second] = self.0.map(|body| body.hand << 4 | body.joint & 0xf);
        1 + (first << 8 | second)
    }

    /// The pair of an index.
    #[must_use]
    pub fn read(index: u32) -> Self {
        let pair = index.saturating_sub(1) as usize;
        Self([pair >> 8, pair & 0xff].map(|body| Body {
            hand: body >> 4,
            joint: body & 0xf,
        }))
    }
}

impl fmt::Display for Body {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let hand = Hand(u32::try_from(self.hand).unwrap_or(u32::MAX));
        write!(f, "{hand} {}", NAMES.get(self.joint).unwrap_or(&"arm"))
    }
}
