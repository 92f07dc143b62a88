//! Interface of a demo: scene, goal and evaluation; one implementation per task.

use atas_console::number;
use robot_model::HandModel;
use serde_json::Value;
use shm_schemas::{Cause, GoalRequest, WorldTruth};

use crate::observed::ObservedRun;

/// Scene, goal, and evaluation by the simulator's ground truth.
pub(crate) trait Scenario {
    fn name(&self) -> &str;
    /// Returns the scene arguments of `atas-sim run`, without seed and pace.
    fn scene_arguments(&self) -> Vec<String>;
    /// Returns the goal for the nominal scene, as a client sends it.
    fn goal(&self) -> GoalRequest;
    /// Returns the acting hand.
    fn hand(&self) -> &HandModel;
    /// Formats the ground truth for the progress line.
    fn progress_text(&self, truth: &WorldTruth) -> String;
    fn evaluate(&self, seen: &ObservedRun) -> Evaluation;
}

#[derive(Clone, Debug)]
pub(crate) struct Evaluation {
    pub(crate) figures: Vec<Figure>,
    pub(crate) outcome: String,
    /// Cause if the hand refused the object.
    pub(crate) cause: Option<Cause>,
    pub(crate) expected: &'static str,
    pub(crate) as_expected: bool,
}

/// Measured figure: table column, JSON key, or both.
#[derive(Clone, Debug)]
pub(crate) struct Figure {
    /// Column heading; `None` if the figure is in JSON only.
    pub(crate) heading: Option<&'static str>,
    pub(crate) text: String,
    pub(crate) key: &'static str,
    /// JSON value; `null` if not finite.
    pub(crate) value: Value,
}

impl Figure {
    /// Makes a figure, rounded to `digits` in the table only; a value that is not finite means
    /// "does not apply".
    pub(crate) fn new(head: &'static str, key: &'static str, value: f64, digits: usize) -> Self {
        Self {
            heading: Some(head),
            text: if value.is_finite() {
                number(value, digits)
            } else {
                "-".into()
            },
            key,
            value: finite(value),
        }
    }

    pub(crate) fn duration(seen: &ObservedRun) -> Self {
        Self::new("took s", "took_s", seen.progress.took_s(), 1)
    }

    pub(crate) fn count(head: &'static str, key: &'static str, value: u32) -> Self {
        Self {
            heading: Some(head),
            text: value.to_string(),
            key,
            value: value.into(),
        }
    }

    pub(crate) fn json_only(key: &'static str, value: impl Into<Value>) -> Self {
        Self {
            heading: None,
            text: String::new(),
            key,
            value: value.into(),
        }
    }
}

/// Converts a number to JSON; `null` if not finite.
pub(crate) fn finite(value: f64) -> Value {
    value.is_finite().then_some(value).into()
}
