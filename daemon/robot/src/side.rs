//! The two hands by name.

/// Which of the two arms with its hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Side {
    /// The arm at positive y.
    Left,
    /// The arm at negative y.
    Right,
}

impl Side {
    /// Both sides in the order of the robot's joints.
    pub const BOTH: [Side; 2] = [Side::Left, Side::Right];

    /// 0 for left, 1 for right: the position in every per-hand array.
    #[must_use]
    pub const fn index(self) -> usize {
        match self {
            Side::Left => 0,
            Side::Right => 1,
        }
    }

    /// Sign of this side's y: +1 left, −1 right. A mirrored quantity is the right one times minus this.
    #[must_use]
    pub const fn y_sign(self) -> f64 {
        match self {
            Side::Left => 1.0,
            Side::Right => -1.0,
        }
    }
}
