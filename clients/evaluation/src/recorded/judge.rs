//! Evaluates a recording against its labels, or fits the model to it.

use anyhow::{bail, ensure};
use rayon::prelude::*;

use super::cases::{Case, Labels, cases};
use super::decision::{Fit, no_labels_error, truths, with_truth};
use super::kind::Kind;
use super::model::Model;
use super::sheet::Sheet;
use super::steps::steps_s;
use super::verdict::Verdict;
use super::{defects, hardness, rupture, slip, touches};

enum Measured {
    Sequences(Vec<slip::Sequence>),
    Squeezes(Vec<hardness::SqueezeStiffness>),
    PeaksN(Vec<f64>),
}

/// Evaluates a recording.
///
/// # Errors
/// No kind of recording has its columns, it has no usable labels, or too few cases to fit.
pub fn evaluate(
    sheet: &Sheet,
    labels: &Labels,
    model: &Model,
    fit: Fit,
) -> anyhow::Result<Verdict> {
    let kind = Kind::from_sheet(sheet)?;
    let look = || defects::check(sheet, &kind, rate_hz(&kind, model));
    let (mut warnings, mut verdict);
    if let Kind::Touch { axes, is_counts } = kind {
        warnings = look()?;
        verdict = touches::evaluate(sheet, labels, model, (axes, is_counts))?;
    } else {
        let cases = labelled(sheet, &kind, labels)?;
        warnings = look()?;
        verdict = match measure(sheet, &kind, &cases, model)? {
            Measured::Sequences(measured) => slip::evaluate(&cases, &measured, labels, model, fit)?,
            Measured::Squeezes(measured) => {
                hardness::evaluate(&cases, &measured, labels, model, fit)?
            }
            Measured::PeaksN(peaks_n) => rupture::evaluate(&cases, &peaks_n, model, fit)?,
        };
    }
    warnings.append(&mut verdict.warnings);
    verdict.warnings = warnings;
    Ok(verdict)
}

/// Fits the constants of one kind to a recording; all others stay as in `model`.
///
/// # Errors
/// As for [`evaluate`].
pub fn train(sheet: &Sheet, labels: &Labels, model: &Model) -> anyhow::Result<Model> {
    let kind = Kind::from_sheet(sheet)?;
    let mut fitted = model.clone();
    let cases = labelled(sheet, &kind, labels)?;
    defects::check(sheet, &kind, rate_hz(&kind, model))?;
    let source = format!("{} cases of {}", cases.len(), sheet.path.display());
    match measure(sheet, &kind, &cases, model)? {
        Measured::Sequences(measured) => {
            let truths = truths(&cases, labels, &[], &model.slip.negative);
            let score = |of: &slip::Sequence| slip::score(&of.levels, f64::INFINITY, &model.slip);
            let scores = measured.iter().map(score);
            fitted.slip.motion_at = slip::fit(&with_truth(scores, &truths))?;
            fitted.slip.rate_hz = slip::rate_hz(&measured, &model.slip);
            fitted.slip.source = source;
        }
        Measured::Squeezes(measured) => {
            let hard = &model.hardness;
            let truths = truths(&cases, labels, &hard.positive, &hard.negative);
            let whole = measured.iter().map(|measured| measured.whole_n_m);
            let first = measured.iter().map(|measured| measured.first_step_n_m);
            fitted.hardness.whole_n_m = hardness::fit(&with_truth(whole, &truths))?;
            fitted.hardness.first_step_n_m = hardness::fit(&with_truth(first, &truths))?;
            fitted.hardness.source = source;
        }
        Measured::PeaksN(peaks_n) => {
            let points: Vec<_> = rupture::points(&cases, &peaks_n).collect();
            ensure!(!points.is_empty(), "{}", no_labels_error());
            fitted.rupture.lines.extend(rupture::fit(&points)?);
            fitted.rupture.source = source;
        }
    }
    Ok(fitted)
}

fn measure(sheet: &Sheet, kind: &Kind, cases: &[Case], model: &Model) -> anyhow::Result<Measured> {
    let rate_hz = rate_hz(kind, model);
    match kind {
        Kind::Slip { elements } => {
            let columns: Vec<usize> = elements.iter().flatten().flatten().copied().collect();
            let is_held = defects::is_held(sheet, &columns);
            for_each_case(sheet, rate_hz, cases, |rows, steps_s| {
                let (rows, steps_s) = match is_held {
                    true => without_repeats(sheet, &columns, rows, steps_s),
                    false => (rows.to_vec(), steps_s.to_vec()),
                };
                slip::measure(sheet, elements, &rows, &steps_s, &model.slip)
            })
            .map(Measured::Sequences)
        }
        Kind::Squeeze { forces, angles } => {
            for_each_case(sheet, rate_hz, cases, |rows, steps_s| {
                hardness::measure(sheet, (forces, angles), rows, steps_s, &model.hardness)
            })
            .map(Measured::Squeezes)
        }
        Kind::Press { force, position } => for_each_case(sheet, rate_hz, cases, |rows, steps_s| {
            rupture::peak_n(sheet, (*force, *position), rows, steps_s, &model.rupture)
        })
        .map(Measured::PeaksN),
        Kind::Touch { .. } => bail!(
            "could not train: a recording of contacts has no constants to \
            fit"
        ),
    }
}

/// Calls a function with the rows of every case and the time steps (s) between them, on all cores.
fn for_each_case<T: Send>(
    sheet: &Sheet,
    rate_hz: f64,
    cases: &[Case],
    of: impl Fn(&[usize], &[f64]) -> anyhow::Result<T> + Sync + Send,
) -> anyhow::Result<Vec<T>> {
    let one = |case: &Case| of(&case.rows, &steps_s(sheet, &case.rows, rate_hz));
    cases.par_iter().map(one).collect()
}

fn without_repeats(
    sheet: &Sheet,
    columns: &[usize],
    rows: &[usize],
    steps_s: &[f64],
) -> (Vec<usize>, Vec<f64>) {
    let mut kept: (Vec<usize>, Vec<f64>) = (Vec::new(), Vec::new());
    let mut since_s = 0.0;
    for (&row, step_s) in rows.iter().zip(steps_s) {
        since_s += step_s;
        let before = kept.0.last();
        if before.is_none_or(|&before| !defects::repeats(sheet, columns, before, row)) {
            kept.0.push(row);
            kept.1.push(since_s);
            since_s = 0.0;
        }
    }
    kept
}

fn labelled(sheet: &Sheet, kind: &Kind, labels: &Labels) -> anyhow::Result<Vec<Case>> {
    ensure!(
        labels.column.is_some(),
        "could not evaluate {} without labels; name a column with --labels, one of {:?} or of \
         another table in its folder",
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
