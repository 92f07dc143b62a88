//! Score of a trial (paper III.b.2): up to 100 points per goal, 800 per evaluation.
//!
//! The paper prints E₁ and E₂. It also compares the positions of agent and object at the ends of
//! execution and evaluation time, but prints no consequence. Hence three fixed rules: the printed
//! formulas, the formulas with our reading of the comparison, and a project rule. A preset may
//! define a weighted sum ([`Weights`]).

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::model::TeamSize;
use crate::preset::Preset;
use crate::trial::{Outcome, Snapshot};
use crate::weights::Weights;

/// K₁ of Eq. (2), points · px.
const K1: f32 = 1000.0;
/// K₂ of Eq. (3), points · frames.
const K2: f32 = 600.0;
/// Points of one goal (paper III.b.3).
pub const GOAL_POINTS: f32 = 100.0;
/// Lower limit of the distance in E₁: a perfect trial scores K₁ / d = 100 points. Design choice.
const DISTANCE_MIN_PX: f32 = 10.0;
/// Margin beyond contact within which an agent is with the object. Design choice; the paper prints
/// none.
const NEAR_OBJECT_MARGIN_PX: f32 = 20.0;

/// Scoring rule of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FitnessRule {
    /// Default: 100 points if the object was [delivered], else E₁, at most its value at the goal's
    /// edge. Accidental deliveries score as near misses. Design choice.
    AntiAccident,
    /// E₁ + E₂ as printed (Eqs. 2 and 3), at most 100 points.
    Literal,
    /// E₁ + E₂, at most 100 points, if the same agent stayed with the object; else E₁, at most its
    /// value at the goal's edge. Our reading of the comparison.
    Compared,
    /// Weighted sum, 0 to 100 points.
    Weighted(Weights),
}

impl fmt::Display for FitnessRule {
    /// Name in files and on command lines.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AntiAccident => f.write_str("anti-accident"),
            Self::Literal => f.write_str("literal"),
            Self::Compared => f.write_str("compared"),
            Self::Weighted(weights) => write!(f, "weighted ({weights})"),
        }
    }
}

impl FitnessRule {
    /// Returns the default rule: the preset's weights, literal for the paper's constants, else
    /// anti-accident.
    #[must_use]
    pub fn default_for(preset: &Preset) -> Self {
        match preset.fitness {
            Some(weights) => Self::Weighted(weights),
            None if *preset == Preset::PAPER => Self::Literal,
            None => Self::AntiAccident,
        }
    }

    /// Returns the points of one trial.
    #[must_use]
    pub fn points(self, preset: &Preset, team: TeamSize, outcome: &Outcome) -> f32 {
        let distance = outcome.evaluated.goal_px;
        let edge = accuracy(preset.goal_radius_px);
        let both = || (accuracy(distance) + efficiency(outcome.reached_frame)).min(GOAL_POINTS);
        match self {
            Self::AntiAccident if delivered(preset, team, outcome) => GOAL_POINTS,
            Self::Compared if accompanied(preset, team, outcome) => both(),
            Self::AntiAccident | Self::Compared => accuracy(distance).min(edge),
            Self::Literal => both(),
            Self::Weighted(weights) => weighted(weights, preset, team, outcome),
        }
    }
}

/// Returns E₁ (Eq. 2), points.
#[must_use]
pub fn accuracy(distance_px: f32) -> f32 {
    K1 / distance_px.max(DISTANCE_MIN_PX)
}

/// Returns E₂ (Eq. 3), points; 0 if the goal was never reached (frame 0).
#[must_use]
pub fn efficiency(reached_frame: u32) -> f32 {
    if reached_frame == 0 {
        0.0
    } else {
        K2 / reached_frame as f32
    }
}

/// Returns true if the same agent is with the object after execution and after evaluation.
#[must_use]
pub fn accompanied(preset: &Preset, team: TeamSize, outcome: &Outcome) -> bool {
    let with = |snapshot: &Snapshot, agent: usize| is_with_object(preset, snapshot, agent);
    (0..team.get()).any(|agent| with(&outcome.executed, agent) && with(&outcome.evaluated, agent))
}

fn weighted(weights: Weights, preset: &Preset, team: TeamSize, outcome: &Outcome) -> f32 {
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
    let terms = weights.terms().into_iter().zip(counted);
    let sum = terms.fold(0.0, |sum, ((_, weight), counted)| sum + weight * counted);
    sum.clamp(0.0, GOAL_POINTS)
}

fn is_with_object(preset: &Preset, snapshot: &Snapshot, agent: usize) -> bool {
    let near_px = preset.agent_radius_px + preset.object_radius_px + NEAR_OBJECT_MARGIN_PX;
    snapshot.agents_px[agent] <= near_px
}

/// Returns true if the object is at the goal at the end and an agent stayed with it. Solved under
/// every rule.
#[must_use]
pub fn delivered(preset: &Preset, team: TeamSize, outcome: &Outcome) -> bool {
    outcome.evaluated.goal_px <= preset.goal_radius_px && accompanied(preset, team, outcome)
}

/// Returns true for the largest score of a goal.
#[must_use]
pub fn solved(points: f32) -> bool {
    points >= GOAL_POINTS
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(
        rule: FitnessRule,
        goal_px: f32,
        executed_px: f32,
        evaluated_px: f32,
        reached: u32,
        expected: f32,
    ) {
        let at = |goal_px, agent_px| Snapshot {
            goal_px,
            agents_px: [agent_px, 0.0, 0.0, 0.0],
        };
        let outcome = Outcome {
            rows_read: 0,
            reached_frame: reached,
            executed: at(goal_px, executed_px),
            evaluated: at(goal_px, evaluated_px),
        };
        let team = TeamSize::new(1).expect("one agent");
        let points = rule.points(&Preset::N, team, &outcome);
        assert_eq!(
            points, expected,
            "{rule:?} goal {goal_px} agents {executed_px} {evaluated_px} reached {reached}"
        );
    }

    #[test]
    fn accidents_score_at_most_the_goal_edge() {
        let edge = 1000.0 / 60.0;
        let rows = [
            (30.0, 80.0, 80.0, 100.0), // delivered
            (30.0, 95.0, 95.0, 100.0), // barely near enough
            (30.0, 96.0, 80.0, edge),  // no agent near at frame 180
            (30.0, 80.0, 300.0, edge), // left alone at frame 270
            (5.0, 300.0, 300.0, edge), // accident, exactly on the goal
            (100.0, 80.0, 80.0, 10.0), // not arrived yet
        ];
        for (goal_px, executed, evaluated, expected) in rows {
            check(
                FitnessRule::AntiAccident,
                goal_px,
                executed,
                evaluated,
                0,
                expected,
            );
        }
    }

    #[test]
    fn literal_rule_is_capped_equations_2_and_3() {
        let rows = [
            (100.0, 0, 10.0),
            (100.0, 60, 20.0),
            (5.0, 0, 100.0),
            (20.0, 6, 100.0),
            (250.0, 0, 4.0),
        ];
        for (goal_px, reached, expected) in rows {
            check(FitnessRule::Literal, goal_px, 0.0, 0.0, reached, expected);
        }
    }

    #[test]
    fn compared_rule_caps_the_score_of_accidents() {
        let edge = 1000.0 / 60.0;
        let rows = [
            (30.0, 80.0, 80.0, 60, 1000.0 / 30.0 + 10.0), // delivered
            (5.0, 80.0, 80.0, 6, 100.0),                  // capped at the largest score
            (100.0, 80.0, 80.0, 60, 20.0),                // in and out again: E2 stays
            (100.0, 80.0, 80.0, 0, 10.0),                 // not arrived yet
            (30.0, 96.0, 80.0, 60, edge),                 // no agent near at frame 180
            (5.0, 80.0, 300.0, 6, edge),                  // left alone at frame 270
        ];
        for (goal_px, executed, evaluated, reached, expected) in rows {
            check(
                FitnessRule::Compared,
                goal_px,
                executed,
                evaluated,
                reached,
                expected,
            );
        }
    }

    #[test]
    fn only_the_largest_score_is_solved() {
        assert!(solved(100.0) && !solved(99.9));
    }

    #[test]
    fn weighted_score_is_the_clamped_sum() {
        // At the goal from frame 60; two of three agents with the object at the end, one
        // throughout.
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
            let points = weighted(weights, &Preset::N, TeamSize::ALL[2], &outcome);
            assert_eq!((points, &*weights.to_string()), (expected, name));
        }
    }
}
