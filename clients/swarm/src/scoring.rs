//! Who says what a trial is worth: a rule that files can name, or a type of one's own.
//!
//! A rule of one's own implements [`Fitness`] and goes into [`crate::condition::Condition::judged_by`]; everything else, from
//! evolution to table files, stays as it is (`examples/own_fitness.rs`). Files keep its name. A program that does not have the
//! type drives robots with such tables and shows what they earned, but judges nothing by it.

use std::fmt;
use std::path::Path;
use std::sync::Arc;

use field::{FitnessRule, GOAL_POINTS, Outcome, Preset, TeamSize, Weights};
use serde::{Deserialize, Serialize, Serializer, de::Deserializer};

use crate::error::{Error, Result};

/// What happened in a trial, for who judges it.
#[derive(Clone, Copy, Debug)]
pub struct Judged<'a> {
    /// The numbers of the field.
    pub preset: &'a Preset,
    /// How many agents there were.
    pub team: TeamSize,
    /// Distances after execution and after evaluation, when the object was first at the goal, which rows were read.
    pub outcome: &'a Outcome,
}

impl Judged<'_> {
    /// See [`field::accuracy`]: E1 of the distance in the end.
    #[must_use]
    pub fn accuracy(&self) -> f32 {
        field::accuracy(self.outcome.evaluated.goal_px)
    }

    /// See [`field::efficiency`]: E2 of the first frame at the goal.
    #[must_use]
    pub fn efficiency(&self) -> f32 {
        field::efficiency(self.outcome.reached_frame)
    }

    /// See [`field::delivered`].
    #[must_use]
    pub fn delivered(&self) -> bool {
        field::delivered(self.preset, self.team, self.outcome)
    }

    /// See [`field::accompanied`].
    #[must_use]
    pub fn accompanied(&self) -> bool {
        field::accompanied(self.preset, self.team, self.outcome)
    }
}

/// A rule of one's own.
pub trait Fitness: fmt::Debug + Send + Sync {
    /// The points of one trial, a function of what happened in it and of nothing else: points are remembered, and tables that
    /// read the same rows are not tried again. Below 0 and what is no number count as 0, above 100 as 100.
    fn points(&self, trial: &Judged<'_>) -> f32;

    /// How files and reports call it: the name of the type, if it does not say otherwise.
    fn name(&self) -> String {
        let path = std::any::type_name::<Self>();
        path.rsplit("::").next().unwrap_or(path).to_owned()
    }
}

/// How trials are scored.
#[derive(Clone, Debug)]
pub enum Scoring {
    /// By a rule that files can name.
    Rule(FitnessRule),
    /// By a rule of one's own.
    Own(Arc<dyn Fitness>),
    /// By a rule of somebody's own that this program does not have; a file named it.
    Elsewhere(String),
}

impl Scoring {
    /// The points of one trial, 0 to 100; 0 by a rule that this program does not have.
    #[must_use]
    pub fn points(&self, trial: &Judged<'_>) -> f32 {
        let Judged {
            preset,
            team,
            outcome,
        } = *trial;
        match self {
            Self::Rule(rule) => rule.points(preset, team, outcome),
            Self::Own(own) => match own.points(trial) {
                points if points > 0.0 => points.min(GOAL_POINTS),
                // NaN included.
                _ => 0.0,
            },
            Self::Elsewhere(_) => 0.0,
        }
    }

    /// Its name without numbers, where there is little room.
    #[must_use]
    pub fn word(&self) -> String {
        match self {
            Self::Rule(FitnessRule::Weighted(_)) => "weighted".to_owned(),
            other => other.to_string(),
        }
    }

    /// Whether this program has the rule.
    #[must_use]
    pub fn is_here(&self) -> bool {
        !matches!(self, Self::Elsewhere(_))
    }

    /// Refuses to judge a table by a rule that this program does not have.
    ///
    /// # Errors
    /// [`Error::Refused`] with this cure.
    pub fn check_here(&self, table: &Path, cure: &str) -> Result<()> {
        if self.is_here() {
            return Ok(());
        }
        Err(Error::refused(
            format_args!("judge {}", table.display()),
            format_args!("its rule {self} is of a type of somebody's own"),
            "a rule that ships",
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
    /// Rules of one's own are what they are called.
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
            Self::Own(own) => f.write_str(&own.name()),
            Self::Elsewhere(name) => f.write_str(name),
        }
    }
}

/// A scoring as files have it: the rules' own form, or `{ own = "NAME" }`.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Written {
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
            own => Written::Own(own.to_string()).serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Scoring {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        Ok(match Written::deserialize(deserializer)? {
            Written::AntiAccident => Self::Rule(FitnessRule::AntiAccident),
            Written::Literal => Self::Rule(FitnessRule::Literal),
            Written::Compared => Self::Rule(FitnessRule::Compared),
            Written::Weighted(weights) => Self::Rule(FitnessRule::Weighted(weights)),
            Written::Own(name) => Self::Elsewhere(name),
        })
    }
}
