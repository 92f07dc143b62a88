//! Under which conditions a task is tried.

use serde::Serialize;

/// How good the sensors are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condition {
    /// Scale of the fingertip sensors' noise.
    pub noise: Noise,
    /// Frames per second of the fingertip sensors.
    pub rate_hz: u32,
}

/// A scale of noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Noise {
    /// The same in every trial.
    Scale(f64),
    /// Drawn for every trial from this range.
    Between([f64; 2]),
}

impl Noise {
    /// The scale of one trial, from a number in 0 to 1 that was drawn for it.
    pub(super) fn at(self, share: f64) -> f64 {
        match self {
            Self::Scale(scale) => scale,
            Self::Between([low, high]) => low + (high - low) * share,
        }
    }
}
