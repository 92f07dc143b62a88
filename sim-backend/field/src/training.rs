//! What tables are evolved on. The field holds the key, because a preset file has it; whoever evolves draws the trials.

use serde::{Deserialize, Serialize};

/// Trials drawn anew for every generation, so that tables learn the task and not eight goals (ours). It says how the field
/// is used, not what it is: [`crate::Preset::fingerprint`] leaves it out, and such tables drive the same robots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Training {
    /// Where agents start.
    pub starts: Places,
    /// Where the goals are.
    pub goals: Places,
    /// Sets of eight goals per generation, 1 to 64. Fewer are sooner done, and reward luck.
    pub draws: u8,
}

impl Default for Training {
    /// Everything drawn; eight sets tell better tables from lucky ones (measured; see the swarm's README).
    fn default() -> Self {
        Self {
            starts: Places::Drawn,
            goals: Places::Drawn,
            draws: 8,
        }
    }
}

/// Whether places are the preset's or drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Places {
    /// Those of the preset.
    Preset,
    /// Starts: anywhere on the field where nothing touches, any heading. Goals: one in each eighth of the circle or square.
    Drawn,
}
