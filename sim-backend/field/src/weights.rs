//! A fitness as a preset asks for it: a sum of what the field counts in every trial.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::fitness::{GOAL_POINTS, accompanied, accuracy, delivered, efficiency, is_with_object};
use crate::model::TeamSize;
use crate::preset::Preset;
use crate::trial::Outcome;

/// What each thing counts for, negative where it is not wanted; nothing if left out. A trial earns the sum, at least 0 and at
/// most 100 points: a full score counts as a solved goal. It says how the field is used, not what it is:
/// [`Preset::fingerprint`] leaves it out.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Weights {
    /// Points if the object is at the goal in the end and an agent stayed with it ([`delivered`]).
    pub delivered: f32,
    /// Points if the object ever was within the goal's radius.
    pub reached: f32,
    /// Points if one and the same agent is with the object after execution and after evaluation ([`accompanied`]).
    pub accompanied: f32,
    /// Points per agent that is with the object in the end.
    pub each_companion: f32,
    /// Times E1 (Eq. 2) of the distance in the end ([`accuracy`]).
    pub accuracy: f32,
    /// Times E2 (Eq. 3) of the first frame at the goal ([`efficiency`]).
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

    pub(crate) fn points(&self, preset: &Preset, team: TeamSize, outcome: &Outcome) -> f32 {
        let is = |is: bool| f32::from(u8::from(is));
        let with = |agent: &usize| is_with_object(preset, &outcome.evaluated, *agent);
        let companions = (0..team.get()).filter(with).count() as f32;
        let counted = [
            is(delivered(preset, team, outcome)),
            is(outcome.reached_frame > 0),
            is(accompanied(preset, team, outcome)),
            companions,
            accuracy(outcome.evaluated.goal_px),
            efficiency(outcome.reached_frame),
        ];
        let terms = self.terms().into_iter().zip(counted);
        let sum = terms.fold(0.0, |sum, ((_, weight), counted)| sum + weight * counted);
        sum.clamp(0.0, GOAL_POINTS)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::Snapshot;

    #[test]
    fn a_trial_earns_the_sum_of_what_is_weighed() {
        // Two of three agents with the object in the end, one of them the whole time; at the goal from frame 60 on.
        let outcome = Outcome {
            rows_read: 0,
            reached_frame: 60,
            executed: Snapshot {
                goal_px: 50.0,
                agents_px: [90.0, 300.0, 300.0, 0.0],
            },
            evaluated: Snapshot {
                goal_px: 50.0,
                agents_px: [90.0, 90.0, 300.0, 0.0],
            },
        };
        let none = Weights::default();
        let rows = [
            (none, 0.0, ""),
            (
                Weights {
                    delivered: 60.0,
                    ..none
                },
                60.0,
                "60 delivered",
            ),
            (
                Weights {
                    reached: 5.0,
                    ..none
                },
                5.0,
                "5 reached",
            ),
            (
                Weights {
                    accompanied: 7.0,
                    ..none
                },
                7.0,
                "7 accompanied",
            ),
            (
                Weights {
                    each_companion: 3.0,
                    ..none
                },
                6.0,
                "3 each_companion",
            ),
            (
                Weights {
                    accuracy: 1.5,
                    ..none
                },
                30.0,
                "1.5 accuracy",
            ),
            (
                Weights {
                    efficiency: 2.0,
                    ..none
                },
                20.0,
                "2 efficiency",
            ),
            (
                Weights {
                    delivered: 60.0,
                    each_companion: -10.0,
                    efficiency: 2.0,
                    ..none
                },
                60.0,
                "60 delivered + -10 each_companion + 2 efficiency",
            ),
            (
                Weights {
                    delivered: 90.0,
                    accuracy: 1.0,
                    ..none
                },
                100.0,
                "90 delivered + 1 accuracy",
            ),
            (
                Weights {
                    each_companion: -1.0,
                    ..none
                },
                0.0,
                "-1 each_companion",
            ),
        ];
        for (weights, expected, name) in rows {
            let points = weights.points(&Preset::N, TeamSize::ALL[2], &outcome);
            assert_eq!((points, &*weights.to_string()), (expected, name));
        }
    }
}
