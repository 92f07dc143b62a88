//! Left and right hand.

/// Arm with hand: left or right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum HandSide {
    /// The arm at positive y.
    Left,
    /// The arm at negative y.
    Right,
}

impl HandSide {
    /// Both sides in the order of the robot's joints.
    pub const BOTH: [HandSide; 2] = [HandSide::Left, HandSide::Right];

    /// Returns the index in per-hand arrays: 0 for left, 1 for right.
    #[must_use]
    pub const fn index(self) -> usize {
        match self {
            HandSide::Left => 0,
            HandSide::Right => 1,
        }
    }

    /// Returns the sign of y on this side: +1 left, −1 right. It mirrors quantities between hands.
    #[must_use]
    pub const fn y_sign(self) -> f64 {
        match self {
            HandSide::Left => 1.0,
            HandSide::Right => -1.0,
        }
    }
}
