//! A fitness as a preset asks for it: a sum of what the field counts in every trial.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What each thing counts for, negative where it is not wanted; nothing if left out. A trial earns the sum, at least 0 and at
/// most 100 points: a full score counts as a solved goal. It says how the field is used, not what it is:
/// [`crate::Preset::fingerprint`] leaves it out.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Weights {
    /// Points if the object is at the goal in the end and an agent stayed with it ([`crate::delivered`]).
    pub delivered: f32,
    /// Points if the object ever was within the goal's radius.
    pub reached: f32,
    /// Points if one and the same agent is with the object after execution and after evaluation ([`crate::accompanied`]).
    pub accompanied: f32,
    /// Points per agent that is with the object in the end.
    pub each_companion: f32,
    /// Times E1 (Eq. 2) of the distance in the end ([`crate::accuracy`]).
    pub accuracy: f32,
    /// Times E2 (Eq. 3) of the first frame at the goal ([`crate::efficiency`]).
    pub efficiency: f32,
}

impl Weights {
    /// The weights by the keys of a file, in its order.
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
    /// `60 delivered + 2 efficiency`
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
