//! Names of the robot bodies, for a [`crate::Reason`] about two bodies that would collide.

use crate::stamp::Hand;
use core::fmt;

/// Body names of one arm and hand, indexed by the joint that moves the body.
const NAMES: [&str; 11] = [
    "shoulder",
    "upper arm",
    "forearm",
    "wrist",
    "palm",
    "finger 1 root",
    "finger 1 middle",
    "fingertip 1",
    "finger 2 root",
    "finger 2 middle",
    "fingertip 2",
];

/// One body of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Body {
    /// 0 left, 1 right.
    pub hand: usize,
    /// Joint of that hand that moves the body, 0 to 10.
    pub joint: usize,
}

/// Two bodies, encoded as the index of a [`crate::ReasonRecord`]; index 0 means none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyPair(pub [Body; 2]);

impl BodyPair {
    /// Encodes the pair as an index.
    ///
    /// ```
    /// use shm_schemas::BodyPair;
    ///
    /// let pair = BodyPair::from_index(5);
    /// assert_eq!(pair.index(), 5);
    /// ```
    #[must_use]
    pub fn index(self) -> u32 {
        let [first, second] = self.0.map(|body| body.hand << 4 | body.joint & 0xf);
        u32::try_from(1 + (first << 8 | second)).unwrap_or(u32::MAX)
    }

    /// Decodes the pair of an index.
    #[must_use]
    pub fn from_index(index: u32) -> Self {
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
