//! Scoring of trials: a built-in rule, or a custom type.
//!
//! A custom rule implements [`Fitness`] and is set with
//! [`crate::condition::Condition::with_fitness`]; evolution and table files work unchanged
//! (`examples/own_fitness.rs`). Files store its name. A program without the type can drive robots
//! with such tables and show their stored points, but cannot evaluate them.

use std::fmt;
use std::path::Path;
use std::sync::Arc;

use field::{FitnessRule, GOAL_POINTS, Outcome, Preset, TeamSize, Weights};
use serde::{Deserialize, Serialize, Serializer, de::Deserializer};

use crate::error::{Error, Result};

/// Result of a trial, the input of a fitness.
#[derive(Clone, Copy, Debug)]
pub struct TrialResult<'a> {
    /// Parameters of the field.
    pub preset: &'a Preset,
    /// Number of agents.
    pub team: TeamSize,
    /// Distances after execution and after evaluation, first frame with the object at the goal,
    /// rows read.
    pub outcome: &'a Outcome,
}

impl TrialResult<'_> {
    /// Returns E1 of the final distance, see [`field::accuracy`].
    #[must_use]
    pub fn accuracy(&self) -> f32 {
        field::accuracy(self.outcome.evaluated.goal_px)
    }

    /// Returns E2 of the first frame at the goal, see [`field::efficiency`].
    #[must_use]
    pub fn efficiency(&self) -> f32 {
        field::efficiency(self.outcome.reached_frame)
    }

    /// Returns whether the object was delivered, see [`field::delivered`].
    #[must_use]
    pub fn delivered(&self) -> bool {
        field::delivered(self.preset, self.team, self.outcome)
    }

    /// Returns whether the object was accompanied, see [`field::accompanied`].
    #[must_use]
    pub fn accompanied(&self) -> bool {
        field::accompanied(self.preset, self.team, self.outcome)
    }
}

/// A custom fitness.
pub trait Fitness: fmt::Debug + Send + Sync {
    /// Returns the points of one trial, clamped to 0–100; NaN counts as 0. Must depend on `trial`
    /// only, because the memo reuses points.
    fn points(&self, trial: &TrialResult<'_>) -> f32;

    /// Returns the name for files and reports; by default the name of the type.
    fn name(&self) -> String {
        let path = std::any::type_name::<Self>();
        path.rsplit("::").next().unwrap_or(path).to_owned()
    }
}

/// Scoring of trials.
#[derive(Clone, Debug)]
pub enum Scoring {
    /// A built-in rule.
    Rule(FitnessRule),
    /// A custom rule.
    Custom(Arc<dyn Fitness>),
    /// A custom rule that a file names and this program does not have.
    Unavailable(String),
}

impl Scoring {
    /// Returns the points of one trial, 0 to 100; 0 for a missing rule.
    #[must_use]
    pub fn points(&self, trial: &TrialResult<'_>) -> f32 {
        let TrialResult {
            preset,
            team,
            outcome,
        } = *trial;
        match self {
            Self::Rule(rule) => rule.points(preset, team, outcome),
            Self::Custom(own) => match own.points(trial) {
                points if points > 0.0 => points.min(GOAL_POINTS),
                // Includes NaN.
                _ => 0.0,
            },
            Self::Unavailable(_) => 0.0,
        }
    }

    /// Returns the short name, without parameters.
    #[must_use]
    pub fn short_name(&self) -> String {
        match self {
            Self::Rule(FitnessRule::Weighted(_)) => "weighted".to_owned(),
            other => other.to_string(),
        }
    }

    /// Returns whether this program has the rule.
    #[must_use]
    pub fn is_available(&self) -> bool {
        !matches!(self, Self::Unavailable(_))
    }

    /// Rejects the evaluation of a table whose rule this program does not have.
    pub fn check_available(&self, table: &Path, cure: &str) -> Result<()> {
        if self.is_available() {
            return Ok(());
        }
        Err(Error::refused(
            format_args!("evaluate {}", table.display()),
            format_args!("its custom rule {self} is not part of this program"),
            "a built-in rule",
            cure,
        ))
    }
}

impl From<FitnessRule> for Scoring {
    fn from(rule: FitnessRule) -> Self {
        Self::Rule(rule)
    }
}

impl PartialEq for Scoring {
    /// Custom rules are compared by name.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Rule(a), Self::Rule(b)) => a == b,
            (Self::Rule(_), _) | (_, Self::Rule(_)) => false,
            (a, b) => a.to_string() == b.to_string(),
        }
    }
}

impl fmt::Display for Scoring {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rule(rule) => rule.fmt(f),
            Self::Custom(own) => f.write_str(&own.name()),
            Self::Unavailable(name) => f.write_str(name),
        }
    }
}

/// Stored form of a scoring: the form of the built-in rule, or `{ own = "NAME" }`.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum StoredScoring {
    AntiAccident,
    Literal,
    Compared,
    Weighted(Weights),
    Own(String),
}

impl Serialize for Scoring {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        match self {
            Self::Rule(rule) => rule.serialize(serializer),
            own => StoredScoring::Own(own.to_string()).serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Scoring {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        Ok(match StoredScoring::deserialize(deserializer)? {
            StoredScoring::AntiAccident => Self::Rule(FitnessRule::AntiAccident),
            StoredScoring::Literal => Self::Rule(FitnessRule::Literal),
            StoredScoring::Compared => Self::Rule(FitnessRule::Compared),
            StoredScoring::Weighted(weights) => Self::Rule(FitnessRule::Weighted(weights)),
            StoredScoring::Own(name) => Self::Unavailable(name),
        })
    }
}
