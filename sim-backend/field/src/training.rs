//! Training conditions of response tables; the evolution draws the trials.

use serde::{Deserialize, Serialize};

/// New trials in every generation, against overfitting to eight goals. Design choice. Not part of
/// [`crate::Preset::fingerprint`]: the tables drive the same robots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Training {
    /// Start poses.
    pub starts: Places,
    /// Goal positions.
    pub goals: Places,
    /// Sets of eight goals per generation, 1 to 64. Fewer are faster but reward luck.
    pub draws: u8,
}

impl Default for Training {
    /// Random starts and goals; eight sets separate better tables from lucky ones (measured; swarm
    /// README).
    fn default() -> Self {
        Self {
            starts: Places::Drawn,
            goals: Places::Drawn,
            draws: 8,
        }
    }
}

/// Source of start or goal positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Places {
    /// Position of the preset.
    Preset,
    /// Random. Starts: any free pose. Goals: one in each eighth of the circle or square.
    Drawn,
}
