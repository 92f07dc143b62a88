//! Evaluation result of a recording.

use std::collections::BTreeMap;

use serde::Serialize;

use super::cases::Case;
use super::decision::{Fit, objects};
use super::kind::Property;
use super::rates::Rates;

/// Evaluation result of a recording.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// Evaluated property.
    pub judged: Property,
    /// Number of evaluated cases, or frames.
    pub n: usize,
    /// Number of cases without a usable label.
    pub skipped: usize,
    /// Number of objects in the evaluated cases.
    pub objects: usize,
    /// Source.
    pub fit: Fit,
    /// Rates of a binary decision.
    #[serde(flatten)]
    pub rates: Option<Rates>,
    /// Threshold of the model; decisions with [`Fit::Across`] use one per object.
    pub threshold: Option<f64>,
    /// Rates of the hardness decision at the first step after contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_step: Option<Rates>,
    /// Rates of the slip decision after shorter durations.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub after: Vec<After>,
    /// Mean absolute error of the rupture force, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mae_n: Option<f64>,
    /// Errors of the rupture force per category.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub sorts: BTreeMap<String, Errors>,
    /// Rows at which contacts begin, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub touches: Option<Vec<usize>>,
    /// Ignored data and assumptions.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// Rates of the slip decision after a given duration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct After {
    /// Time since the beginning of the case, s.
    pub s: f64,
    /// Rates of the decision.
    #[serde(flatten)]
    pub rates: Rates,
}

/// Errors of the rupture force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// Number of presses.
    pub n: usize,
    /// Mean absolute error, N.
    pub mae_n: f64,
    /// Mean absolute error of the mean of all other presses, N.
    pub mae_of_mean_n: f64,
    /// Median overload at the time of the prediction, N.
    pub beyond_n: f64,
}

impl Verdict {
    pub(super) fn with_counts(
        judged: Property,
        cases: &[Case],
        truths: &[Option<bool>],
        fit: Fit,
    ) -> Self {
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
