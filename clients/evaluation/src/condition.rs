//! Under which conditions a task is tried.

use serde::Serialize;
use sim_backend::Errors;

/// How good the sensors are, and how far the rest is from what the controller was made for.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// Scale of the fingertip sensors' noise.
    pub noise: Noise,
    /// Frames per second of the fingertip sensors.
    pub rate_hz: u32,
    /// Errors of robot, skins, objects, and of what a client is told.
    pub errors: Named,
}

/// Errors with the name under which they are reported.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// As a user would ask for them: `none`, `crosstalk`, `position=2,yaw=5`.
    pub name: String,
    /// The errors.
    pub errors: Errors,
}

impl Named {
    /// None.
    #[must_use]
    pub fn none() -> Self {
        Self {
            name: "none".to_owned(),
            errors: Errors::NONE,
        }
    }
}

impl core::str::FromStr for Named {
    type Err = sim_backend::ErrorSpecError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(Self {
            name: text.to_owned(),
            errors: text.parse()?,
        })
    }
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
