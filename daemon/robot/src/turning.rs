//! What turns a hand that points down about the vertical, as it was read off the reference posture.

/// Bearing and roll at which a hand that points down has a closing yaw: yaw = bearing + `yaw_rad` − roll.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Turning {
    /// The arm's first joint turns it about the vertical: its angle is `sign`·bearing + `zero_rad`.
    pub(crate) base: Option<Turn>,
    /// The arm's last joint turns the hand about its pointing direction: its angle is `sign`·roll + `zero_rad`.
    pub(crate) wrist: Option<Turn>,
    pub(crate) yaw_rad: f64,
}

/// How a joint's angle follows another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Turn {
    pub(crate) sign: f64,
    pub(crate) zero_rad: f64,
}
