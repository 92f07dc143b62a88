//! Weighted fitness of a preset.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Weight per quantity; negative penalises. A trial scores the sum, clamped to 0 to 100 points; a
/// full score counts as solved. Not part of [`crate::Preset::fingerprint`].
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Weights {
    /// Points if the object was delivered ([`crate::delivered`]).
    pub delivered: f32,
    /// Points if the object ever reached the goal.
    pub reached: f32,
    /// Points if the same agent stayed with the object ([`crate::accompanied`]).
    pub accompanied: f32,
    /// Points per agent with the object at the end.
    pub each_companion: f32,
    /// Factor of E1 ([`crate::accuracy`]).
    pub accuracy: f32,
    /// Factor of E2 ([`crate::efficiency`]).
    pub efficiency: f32,
}

impl Weights {
    /// Weights with their keys, in file order.
    pub(crate) fn terms(&self) -> [(&'static str, f32); 6] {
        [
            ("fitness.delivered", self.delivered),
            ("fitness.reached", self.reached),
            ("fitness.accompanied", self.accompanied),
            ("fitness.each_companion", self.each_companion),
            ("fitness.accuracy", self.accuracy),
            ("fitness.efficiency", self.efficiency),
        ]
    }
}

impl fmt::Display for Weights {
    /// Example: `60 delivered + 2 efficiency`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let terms = self
            .terms()
            .into_iter()
            .filter(|(_, weight)| *weight != 0.0);
        for (place, (key, weight)) in terms.enumerate() {
            let plus = if place == 0 { "" } else { " + " };
            write!(f, "{plus}{weight} {}", key.trim_start_matches("fitness."))?;
        }
        Ok(())
    }
}
