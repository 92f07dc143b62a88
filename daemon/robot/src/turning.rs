//! Joints that turn a hand about the vertical while it points down, determined at the reference
//! posture.

/// Bearing and roll at which a hand that points down has a closing yaw: yaw = bearing + `yaw_rad` −
/// roll.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Turning {
    /// Arm's first joint, if it turns the hand about the vertical: its position is `sign`·bearing +
    /// `zero_rad`.
    pub(crate) base: Option<Turn>,
    /// Arm's last joint, if it turns the hand about its pointing direction: its position is
    /// `sign`·roll + `zero_rad`.
    pub(crate) wrist: Option<Turn>,
    pub(crate) yaw_rad: f64,
}

/// Linear relation between a joint position and an angle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Turn {
    pub(crate) sign: f64,
    pub(crate) zero_rad: f64,
}
