//! Conditions of an evaluation: sensor noise, sensor rate and errors.

use serde::Serialize;
use sim_backend::Errors;

/// Condition of a trial: sensor quality, and deviations of the world from the nominal model.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// Scale of the fingertip sensors' noise.
    pub noise: Noise,
    /// Frames per second of the fingertip sensors.
    pub rate_hz: u32,
    /// Errors of robot, skins, objects, and of the data given to the client.
    pub errors: NamedErrors,
}

/// Errors with their name in reports.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedErrors {
    /// Specification as users type it: `none`, `crosstalk`, `position=2,yaw=5`.
    pub name: String,
    /// The errors.
    pub errors: Errors,
}

impl NamedErrors {
    /// Returns no errors.
    #[must_use]
    pub fn none() -> Self {
        Self {
            name: "none".to_owned(),
            errors: Errors::NONE,
        }
    }
}

impl core::str::FromStr for NamedErrors {
    type Err = sim_backend::ErrorSpecError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(Self {
            name: text.to_owned(),
            errors: text.parse()?,
        })
    }
}

/// Noise scale.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Noise {
    /// Constant.
    Scale(f64),
    /// Drawn for each trial from this range.
    Between([f64; 2]),
}

impl Noise {
    /// Returns the scale of one trial from its random number in 0 to 1.
    pub(super) fn scale(self, share: f64) -> f64 {
        match self {
            Self::Scale(scale) => scale,
            Self::Between([low, high]) => low + (high - low) * share,
        }
    }
}
