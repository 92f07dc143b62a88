//! The verdict on a recording.

use std::collections::BTreeMap;

use serde::Serialize;

use super::cases::Case;
use super::decision::{Fit, objects};
use super::kind::Judged;
use super::rates::Rates;

/// What a recording says about perception.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// What was judged.
    pub judged: Judged,
    /// Cases, or frames, that were judged.
    pub n: usize,
    /// Cases without a label of use.
    pub skipped: usize,
    /// Objects among them.
    pub objects: usize,
    /// Which constants judged.
    pub fit: Fit,
    /// Rates of a decision between two.
    #[serde(flatten)]
    pub rates: Option<Rates>,
    /// Threshold of the model; the decisions of [`Fit::Across`] have one per object.
    pub threshold: Option<f64>,
    /// Hardness at the first step after touch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_step: Option<Rates>,
    /// Slip when judged sooner.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub after: Vec<After>,
    /// Mean absolute error of the force, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mae_n: Option<f64>,
    /// The same by sort of thing.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub sorts: BTreeMap<String, Errors>,
    /// Rows at which touches begin, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub touches: Option<Vec<usize>>,
    /// What was left out or taken for granted.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// Slip judged by what was felt until then.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct After {
    /// Time since the beginning, s.
    pub s: f64,
    /// Rates.
    #[serde(flatten)]
    pub rates: Rates,
}

/// Errors of a force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// Presses.
    pub n: usize,
    /// Mean absolute error, N.
    pub mae_n: f64,
    /// That of saying the mean of all others, N.
    pub mae_of_mean_n: f64,
    /// How far beyond the true force it was known, median, N: what knowing it costs.
    pub beyond_n: f64,
}

impl Verdict {
    /// Counts alone; nothing is judged yet.
    pub(super) fn of(judged: Judged, cases: &[Case], truths: &[Option<bool>], fit: Fit) -> Self {
        let n = truths.iter().flatten().count();
        Self {
            judged,
            n,
            skipped: truths.len() - n,
            objects: objects(cases, truths).len(),
            fit,
            rates: None,
            threshold: None,
            first_step: None,
            after: Vec::new(),
            mae_n: None,
            sorts: BTreeMap::new(),
            touches: None,
            warnings: Vec::new(),
        }
    }
}
