//! What a demo shows, and how it is judged: one small implementation per task.

use atas_console::number;
use serde_json::Value;
use shm_schemas::{Cause, GoalRequest, WorldTruth};

use super::seen::Seen;

/// A scene, a goal, and a judgement by the simulator's truth.
pub(super) trait Scenario {
    /// What it is about, in one word.
    fn name(&self) -> &str;
    /// Arguments of `atas-sim run` that set the scene; the seed and the pace are not among them.
    fn setting(&self) -> Vec<String>;
    /// The goal, as a client that knows the scene only nominally would send it.
    fn goal(&self) -> GoalRequest;
    /// What of the truth is worth watching.
    fn live(&self, truth: &WorldTruth) -> String;
    /// What became of it.
    fn judge(&self, seen: &Seen) -> Judged;
}

/// The judgement of a scenario.
#[derive(Clone, Debug)]
pub(super) struct Judged {
    /// What was measured, in the order of the table's columns.
    pub(super) figures: Vec<Figure>,
    /// What became of it.
    pub(super) outcome: String,
    /// Why the hand refused it, if it did.
    pub(super) cause: Option<Cause>,
    /// What should become of it.
    pub(super) should: &'static str,
    /// Whether it did.
    pub(super) as_expected: bool,
}

/// One figure: a column of the table, a key of the JSON, or both.
#[derive(Clone, Debug)]
pub(super) struct Figure {
    /// Head of its column; `None` if it is for programs only.
    pub(super) head: Option<&'static str>,
    /// Its text in the table.
    pub(super) text: String,
    /// Its key.
    pub(super) key: &'static str,
    /// Its value. JSON has no infinity: `null`.
    pub(super) value: Value,
}

impl Figure {
    /// A number with so many digits in the table and all of them in the JSON; what never was is not finite.
    pub(super) fn new(head: &'static str, key: &'static str, value: f64, digits: usize) -> Self {
        Self {
            head: Some(head),
            text: if value.is_finite() {
                number(value, digits)
            } else {
                "-".into()
            },
            key,
            value: finite(value),
        }
    }

    /// How long the goal took.
    pub(super) fn took(seen: &Seen) -> Self {
        Self::new("took s", "took_s", seen.progress.took_s(), 1)
    }

    /// A count.
    pub(super) fn count(head: &'static str, key: &'static str, value: u32) -> Self {
        Self {
            head: Some(head),
            text: value.to_string(),
            key,
            value: value.into(),
        }
    }

    /// A value for programs only.
    pub(super) fn hidden(key: &'static str, value: impl Into<Value>) -> Self {
        Self {
            head: None,
            text: String::new(),
            key,
            value: value.into(),
        }
    }
}

/// JSON has no infinity and no NaN: `null`.
pub(super) fn finite(value: f64) -> Value {
    value.is_finite().then_some(value).into()
}
