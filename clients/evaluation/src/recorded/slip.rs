//! Slip detection: the pattern of readings moves beyond the sensor noise for most of the time.

use anyhow::{Context, ensure};
use atas_core::settings::Settings;

use super::cases::{Case, Labels};
use super::decision::{Fit, Fitter, decide, no_labels_error, one_class_error, truths};
use super::kind::Property;
use super::model::{Model, Slip};
use super::rates::{Rates, Scored};
use super::sheet::Sheet;
use super::skin::{Reading, Skin};
use super::verdict::{After, Verdict};
use crate::statistics::median;

/// Durations after which slip is also evaluated, s: accuracy over waiting time.
const AFTER_S: [f64; 4] = [0.5, 1.0, 1.5, 2.0];
/// Distance of the threshold above the mean of stable contacts, in standard deviations of the
/// logarithm. Design choice: 0.5 % of stable contacts exceed it.
const CLEARANCE: f64 = 2.6;
/// Lower limit of that standard deviation. Design choice: three stable contacts can agree by
/// chance.
const DEVIATION_MIN: f64 = 0.1;
/// Lower limit of a score, so that its logarithm is finite.
const SCORE_MIN: f64 = 1e-3;

/// Limit of an element's reading, N: the setting's maximum, because counts have any size.
const ELEMENT_FORCE_MAX_N: f64 = 100_000.0;

#[derive(Clone, Copy, Debug)]
pub(super) struct Level {
    /// Time since the beginning of the case, s.
    pub(super) at_s: f64,
    /// Motion in multiples of the noise.
    pub(super) level: f64,
}

#[derive(Clone, Debug)]
pub(super) struct Sequence {
    pub(super) levels: Vec<Level>,
    /// Median frame period, s.
    pub(super) step_s: f64,
}

pub(super) fn measure(
    sheet: &Sheet,
    elements: &[[Option<usize>; 3]],
    rows: &[usize],
    steps_s: &[f64],
    model: &Slip,
) -> anyhow::Result<Sequence> {
    let mut settings = Settings::default();
    for (name, value) in [
        ("perception.motion_window_s", model.motion_window_s),
        ("perception.motion_at", model.motion_at),
        ("intake.element_force_n", ELEMENT_FORCE_MAX_N),
    ] {
        settings
            .set(name, value)
            .map_err(|error| anyhow::anyhow!("{error}"))?;
    }
    // Single-axis electrodes are in counts, three-axis forces in newtons.
    let scale = if elements.iter().all(|axes| axes[1].is_none()) {
        model.newtons_per_count
    } else {
        1.0
    };
    let mut skin = Skin::new(1, elements.len(), model.rate_hz, settings);
    let (mut found, mut at_s, mut seen) = (Vec::new(), 0.0, 0);
    for (&row, &step_s) in rows.iter().zip(steps_s) {
        at_s += step_s;
        let motion = skin
            .process(step_s, &[reading(sheet, elements, row, scale)])
            .fingertips[0]
            .motion;
        if motion.comparisons != seen {
            seen = motion.comparisons;
            found.push(Level {
                at_s,
                level: motion.level,
            });
        }
    }
    Ok(Sequence {
        levels: found,
        step_s: median(steps_s.to_vec()).unwrap_or(1.0 / model.rate_hz),
    })
}

pub(super) fn rate_hz(sequences: &[Sequence], model: &Slip) -> f64 {
    let steps_s = sequences.iter().map(|sequence| sequence.step_s);
    median(steps_s.collect()).map_or(model.rate_hz, |step_s| 1.0 / step_s)
}

/// Reads one row. An element without a normal reading is invalid; missing tangential readings are
/// 0.
fn reading(sheet: &Sheet, elements: &[[Option<usize>; 3]], row: usize, scale: f64) -> Reading {
    let axis = |column: Option<usize>| column.and_then(|column| sheet.number(row, column));
    elements
        .iter()
        .map(|&[n, t1, t2]| {
            axis(n).map(|n| {
                [n, axis(t1).unwrap_or(0.0), axis(t2).unwrap_or(0.0)].map(|value| value * scale)
            })
        })
        .collect()
}

/// Returns the motion exceeded during `moving_share` of the time until `until_s`; 0 without a
/// comparison.
pub(super) fn score(levels: &[Level], until_s: f64, model: &Slip) -> f64 {
    let mut of: Vec<f64> = levels
        .iter()
        .filter(|level| level.at_s <= until_s)
        .map(|level| level.level)
        .collect();
    of.sort_by(f64::total_cmp);
    let Some(last) = of.len().checked_sub(1) else {
        return 0.0;
    };
    let place = (1.0 - model.moving_share) * last as f64;
    let (below, above) = (place.floor() as usize, place.ceil() as usize);
    of[below] + (of[above] - of[below]) * place.fract()
}

/// Fits the threshold to the scores of stable contacts only; no recorded slip is needed.
pub(super) fn fit(scores: &[(f64, bool)]) -> anyhow::Result<f64> {
    let stable: Vec<f64> = scores
        .iter()
        .filter(|(_, is)| !is)
        .map(|(score, _)| score.max(SCORE_MIN).ln())
        .collect();
    ensure!(
        stable.len() >= 3,
        "could not fit slip: the recording has {} stable contacts, but 3 or more are needed",
        stable.len()
    );
    let mean = stable.iter().sum::<f64>() / stable.len() as f64;
    let deviation = crate::statistics::deviation(&stable).context("a deviation")?;
    let threshold = (mean + CLEARANCE * deviation.max(DEVIATION_MIN)).exp();
    // Motion below the noise is not detectable.
    Ok(threshold.max(1.0))
}

pub(super) fn evaluate(
    cases: &[Case],
    sequences: &[Sequence],
    labels: &Labels,
    model: &Model,
    how: Fit,
) -> anyhow::Result<Verdict> {
    let truths = truths(cases, labels, &[], &model.slip.negative);
    let across = (how == Fit::Across).then_some(fit as Fitter);
    let threshold = model.slip.motion_threshold(rate_hz(sequences, &model.slip));
    let until = |until_s: f64| -> anyhow::Result<Vec<Scored>> {
        let scores: Vec<f64> = sequences
            .iter()
            .map(|sequence| score(&sequence.levels, until_s, &model.slip))
            .collect();
        decide(cases, &scores, &truths, threshold, across)
    };
    let mut verdict = Verdict::with_counts(Property::Slip, cases, &truths, how);
    ensure!(verdict.n > 0, "{}", no_labels_error());
    let rates = Rates::from_cases(&until(f64::INFINITY)?);
    ensure!(
        rates.is_some(),
        "{}",
        one_class_error(&truths, ["slip", "stable"])
    );
    let levels = || sequences.iter().map(|sequence| &sequence.levels);
    let short = levels().filter(|levels| levels.is_empty()).count();
    ensure!(
        short < sequences.len(),
        "could not evaluate: no case is as long as two windows of {} s; a column sequence, sample \
         or trial groups the rows into cases",
        model.slip.motion_window_s
    );
    let moves = levels().flatten().any(|level| level.level > 0.0);
    ensure!(
        moves,
        "could not evaluate: the readings have no noise, which is the unit of motion; use a \
         recording that is not smoothed or rounded"
    );
    if short > 0 {
        verdict.warnings.push(format!(
            "{short} of {} cases are shorter than two windows of {} s and count as stable",
            sequences.len(),
            model.slip.motion_window_s
        ));
    }
    verdict.rates = rates;
    verdict.threshold = Some(threshold);
    for s in AFTER_S {
        if let Some(rates) = Rates::from_cases(&until(s)?) {
            verdict.after.push(After { s, rates });
        }
    }
    Ok(verdict)
}

/// Returns the largest motion in frames of forces (N), in multiples of their noise; 0 if too short.
/// Without contact, it is the lower limit of the threshold.
#[must_use]
pub fn greatest_motion(frames: &[Vec<[f64; 3]>], step_s: f64) -> f64 {
    let elements = frames.first().map_or(1, Vec::len);
    let rate_hz = if step_s > 0.0 { 1.0 / step_s } else { 1.0 };
    let mut skin = Skin::new(1, elements, rate_hz, Settings::default());
    let mut greatest: f64 = 0.0;
    for frame in frames {
        let reading: Reading = frame.iter().copied().map(Some).collect();
        let motion = skin.process(step_s, &[reading]).fingertips[0].motion;
        greatest = greatest.max(motion.level);
    }
    greatest
}
