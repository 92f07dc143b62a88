//! Scores against labels: what is fitted, what is judged, and the verdict.

use std::collections::BTreeMap;

use anyhow::{bail, ensure};
use rayon::prelude::*;
use serde::Serialize;

use super::cases::{Case, Labels, cases};
use super::decision::{Fit, known, no_labels, objects, truths};
use super::kind::{Judged, Kind};
use super::model::Model;
use super::rates::Rates;
use super::sheet::Sheet;
use super::skin::RATE_MAX_HZ;
use super::{hardness, rupture, slip, touches};
use crate::statistics::median;

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

/// Judges a recording.
///
/// # Errors
/// Its columns fit nothing, its labels say nothing, or there is too little to fit.
pub fn judge(sheet: &Sheet, labels: &Labels, model: &Model, fit: Fit) -> anyhow::Result<Verdict> {
    let kind = Kind::of(sheet)?;
    if let Kind::Touch { axes, is_counts } = kind {
        return touches::judge(sheet, labels, model, (axes, is_counts));
    }
    let cases = labelled(sheet, &kind, labels)?;
    let steps = |case: &Case| steps_s(sheet, &case.rows, rate_hz(&kind, model));
    match &kind {
        Kind::Slip { elements } => {
            let levels = feel(&cases, |case| {
                slip::levels(sheet, elements, &case.rows, &steps(case), &model.slip)
            })?;
            slip::judge(&cases, &levels, labels, model, fit)
        }
        Kind::Squeeze { forces, angles } => {
            let felt = feel(&cases, |case| {
                hardness::feel(
                    sheet,
                    (forces, angles),
                    &case.rows,
                    &steps(case),
                    &model.hardness,
                )
            })?;
            hardness::judge(&cases, &felt, labels, model, fit)
        }
        Kind::Press { force, position } => {
            let peaks = feel(&cases, |case| {
                let columns = (*force, *position);
                rupture::peak_n(sheet, columns, &case.rows, &steps(case), &model.rupture)
            })?;
            rupture::judge(&cases, &peaks, model, fit)
        }
        Kind::Touch { .. } => bail!("touches have no cases"),
    }
}

/// Fits what can be fitted to a recording; everything else stays as in `model`.
///
/// # Errors
/// As for [`judge`].
pub fn train(sheet: &Sheet, labels: &Labels, model: &Model) -> anyhow::Result<Model> {
    let kind = Kind::of(sheet)?;
    let mut fitted = model.clone();
    let cases = labelled(sheet, &kind, labels)?;
    let steps = |case: &Case| steps_s(sheet, &case.rows, rate_hz(&kind, model));
    let source = format!("{} cases of {}", cases.len(), sheet.path.display());
    match &kind {
        Kind::Slip { elements } => {
            let levels = feel(&cases, |case| {
                slip::levels(sheet, elements, &case.rows, &steps(case), &model.slip)
            })?;
            let truths = truths(&cases, labels, &[], &model.slip.negative);
            let scores = levels
                .iter()
                .map(|levels| slip::score(levels, f64::INFINITY, &model.slip));
            fitted.slip.motion_at = slip::fit(&known(scores, &truths))?;
            fitted.slip.source = source;
        }
        Kind::Squeeze { forces, angles } => {
            let felt = feel(&cases, |case| {
                hardness::feel(
                    sheet,
                    (forces, angles),
                    &case.rows,
                    &steps(case),
                    &model.hardness,
                )
            })?;
            let hard = &model.hardness;
            let truths = truths(&cases, labels, &hard.positive, &hard.negative);
            let whole = felt.iter().map(|felt| felt.whole_n_m);
            let first = felt.iter().map(|felt| felt.first_step_n_m);
            fitted.hardness.whole_n_m = hardness::fit(&known(whole, &truths))?;
            fitted.hardness.first_step_n_m = hardness::fit(&known(first, &truths))?;
            fitted.hardness.source = source;
        }
        Kind::Press { force, position } => {
            let peaks = feel(&cases, |case| {
                let columns = (*force, *position);
                rupture::peak_n(sheet, columns, &case.rows, &steps(case), &model.rupture)
            })?;
            let points: Vec<_> = rupture::points(&cases, &peaks).collect();
            ensure!(!points.is_empty(), "{}", no_labels());
            fitted.rupture.lines.extend(rupture::fit(&points)?);
            fitted.rupture.source = source;
        }
        Kind::Touch { .. } => bail!("could not train on touches: nothing about them is fitted"),
    }
    Ok(fitted)
}

/// Production perception on every case, on all cores; results in the order of the cases.
fn feel<T: Send>(
    cases: &[Case],
    of: impl Fn(&Case) -> anyhow::Result<T> + Sync + Send,
) -> anyhow::Result<Vec<T>> {
    cases.par_iter().map(of).collect()
}

fn labelled(sheet: &Sheet, kind: &Kind, labels: &Labels) -> anyhow::Result<Vec<Case>> {
    ensure!(
        labels.column.is_some(),
        "could not judge {} without labels; name their column with --labels, one of {:?} or of a table beside it",
        sheet.path.display(),
        sheet.columns()
    );
    cases(sheet, kind, labels)
}

fn rate_hz(kind: &Kind, model: &Model) -> f64 {
    match kind {
        Kind::Slip { .. } => model.slip.rate_hz,
        Kind::Squeeze { .. } => model.hardness.rate_hz,
        Kind::Press { .. } => model.rupture.rate_hz,
        Kind::Touch { .. } => model.touch.rate_hz,
    }
}

/// Time from frame to frame, s: as recorded, else as the model says. Time that does not go on is taken to do so, and frames
/// that came faster than any sensor's were stamped when a file was decoded.
pub(super) fn steps_s(sheet: &Sheet, rows: &[usize], rate_hz: f64) -> Vec<f64> {
    let (column, unit_s) = match (
        sheet.first_of(&["t_s", "time_s", "t_s_approx"]),
        sheet.column("captured_ns"),
    ) {
        (Some(column), _) => (Some(column), 1.0),
        (None, column) => (column, 1e-9),
    };
    let usual_s = 1.0 / rate_hz;
    let time_s = |row: usize| Some(sheet.number(row, column?)? * unit_s);
    let mut before_s: Option<f64> = None;
    let steps: Vec<f64> = rows
        .iter()
        .map(|&row| {
            let now_s = time_s(row);
            let step_s = match (before_s, now_s) {
                (Some(before_s), Some(now_s)) if now_s > before_s => now_s - before_s,
                _ => usual_s,
            };
            before_s = now_s.or(before_s.map(|before_s| before_s + usual_s));
            step_s
        })
        .collect();
    if median(steps.clone()).is_some_and(|step_s| step_s < 1.0 / RATE_MAX_HZ) {
        return vec![usual_s; rows.len()];
    }
    steps
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
        }
    }
}
