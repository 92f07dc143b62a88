//! Maps labels to truths, and scores to decisions.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Context;
use serde::Serialize;

use super::cases::{Case, Labels};
use super::rates::Scored;

/// Source of the constants that evaluate a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fit {
    /// Constants of the model.
    Given,
    /// Fitted per object on all other objects of the recording (leave-one-object-out).
    Across,
}

/// Fits a threshold to pairs of score and truth.
pub(super) type Fitter = fn(&[(f64, bool)]) -> anyhow::Result<f64>;

/// Error text: no case has a usable label.
pub(super) fn no_labels_error() -> &'static str {
    "could not evaluate: no case has a usable label; define the meaning of the values with \
     --positive and --negative"
}

/// Error text: all usable labels belong to one class.
pub(super) fn one_class_error(truths: &[Option<bool>], [positive, negative]: [&str; 2]) -> String {
    let known = truths.iter().flatten().count();
    let class = match truths.iter().flatten().any(|is| *is) {
        true => positive,
        false => negative,
    };
    format!(
        "could not evaluate: all {known} usable labels mean {class}, but both {positive} and \
         {negative} are needed; define the meaning of the values with --positive and --negative"
    )
}

/// Returns the truth of each case: `Some(true)` for slip or hard, `None` without a usable label.
/// Labels 0/1, false/true and no/yes need no definition.
pub(super) fn truths(
    cases: &[Case],
    labels: &Labels,
    positive: &[String],
    negative: &[String],
) -> Vec<Option<bool>> {
    let plain = |label: &str| match label.to_ascii_lowercase().as_str() {
        "1" | "1.0" | "true" | "yes" => Some(true),
        "0" | "0.0" | "false" | "no" => Some(false),
        _ => None,
    };
    let message = !labels.positive.is_empty() || !labels.negative.is_empty();
    let (positive, negative) = if message {
        (labels.positive.as_slice(), labels.negative.as_slice())
    } else {
        (positive, negative)
    };
    let is_plain = !message
        && cases
            .iter()
            .all(|case| case.label.is_empty() || plain(&case.label).is_some());
    let among = |label: &str, values: &[String]| values.iter().any(|value| is_same(value, label));
    let meaning = |case: &Case| match case.label.as_str() {
        "" => None,
        label if is_plain => plain(label),
        label if among(label, negative) => Some(false),
        label if among(label, positive) => Some(true),
        _ if positive.is_empty() => Some(true),
        _ if negative.is_empty() => Some(false),
        _ => None,
    };
    cases.iter().map(meaning).collect()
}

fn is_same(a: &str, b: &str) -> bool {
    match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => a == b,
        _ => a.eq_ignore_ascii_case(b),
    }
}

pub(super) fn with_truth(
    scores: impl Iterator<Item = f64>,
    truths: &[Option<bool>],
) -> Vec<(f64, bool)> {
    let pairs = scores.zip(truths);
    pairs
        .filter_map(|(score, truth)| Some((score, (*truth)?)))
        .collect()
}

/// Decides each case by the given threshold, or by one that `across` fits on all other objects.
pub(super) fn decide(
    cases: &[Case],
    scores: &[f64],
    truths: &[Option<bool>],
    threshold: f64,
    across: Option<Fitter>,
) -> anyhow::Result<Vec<Scored>> {
    let mut thresholds: BTreeMap<&str, f64> = BTreeMap::new();
    if let Some(fit) = across {
        for object in objects(cases, truths) {
            let others: Vec<(f64, bool)> = (0..cases.len())
                .filter(|&case| cases[case].object != object)
                .filter_map(|case| Some((scores[case], truths[case]?)))
                .collect();
            let fitted = fit(&others).with_context(|| format!("leaving out {object:?}"))?;
            thresholds.insert(object, fitted);
        }
    }
    let decided = (0..cases.len()).filter_map(|case| {
        let at = thresholds
            .get(cases[case].object.as_str())
            .copied()
            .unwrap_or(threshold);
        Some(Scored {
            score: scores[case],
            decision: scores[case] > at,
            truth: truths[case]?,
        })
    });
    Ok(decided.collect())
}

pub(super) fn objects<'a>(cases: &'a [Case], truths: &[Option<bool>]) -> BTreeSet<&'a str> {
    let known = cases.iter().zip(truths);
    known
        .filter(|(_, truth)| truth.is_some())
        .map(|(case, _)| case.object.as_str())
        .collect()
}
