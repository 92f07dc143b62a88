//! Slip against stable touch: for most of the time the pattern of readings must move, beyond the sensor's own noise.

use anyhow::{Context, ensure};
use atas_core::settings::Settings;

use super::cases::{Case, Labels};
use super::decision::{Fit, Fitter, decide, no_labels, one_class, truths};
use super::kind::Judged;
use super::model::{Model, Slip};
use super::rates::{Rates, Scored};
use super::sheet::Sheet;
use super::skin::{Reading, Skin};
use super::verdict::{After, Verdict};
use crate::statistics::median;

/// Times after which slip is judged as well: what the waiting buys, s.
const AFTER_S: [f64; 4] = [0.5, 1.0, 1.5, 2.0];
/// Standard deviations of the logarithm by which the threshold stands above what stable touches do (ours: one in two hundred of
/// them lies beyond).
const CLEARANCE: f64 = 2.6;
/// Least deviation of that logarithm (ours: three stable touches may be alike by chance).
const DEVIATION_MIN: f64 = 0.1;
/// Least score, so that it has a logarithm.
const SCORE_MIN: f64 = 1e-3;

/// What an element may read at most, N: the settings' own limit, since a count may stand for anything.
const ANY_N: f64 = 100_000.0;

/// What was felt at one comparison of windows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Level {
    /// Since the beginning of the case, s.
    pub(super) at_s: f64,
    /// Motion in multiples of the noise.
    pub(super) level: f64,
}

/// What was felt in one case.
#[derive(Clone, Debug)]
pub(super) struct Sequence {
    /// At each comparison.
    pub(super) levels: Vec<Level>,
    /// Median time from frame to frame, s.
    pub(super) step_s: f64,
}

/// What production perception feels in one case.
pub(super) fn feel(
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
        ("intake.element_force_n", ANY_N),
    ] {
        settings
            .set(name, value)
            .map_err(|error| anyhow::anyhow!("{error}"))?;
    }
    // Bare electrodes count; forces are newtons already.
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
            .feel(step_s, &[reading(sheet, elements, row, scale)])
            .fingers[0]
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

/// Frames per second of most cases, Hz.
pub(super) fn rate_hz(sequences: &[Sequence], model: &Slip) -> f64 {
    let steps_s = sequences.iter().map(|sequence| sequence.step_s);
    median(steps_s.collect()).map_or(model.rate_hz, |step_s| 1.0 / step_s)
}

/// An element whose first axis is missing says nothing; further axes that are missing are taken to feel nothing.
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

/// The motion that was exceeded for the share of the time that slip needs; 0 for what is too short to say.
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

/// The threshold that stable touches keep below: learnt from them alone, so that no slip need be recorded.
pub(super) fn fit(scores: &[(f64, bool)]) -> anyhow::Result<f64> {
    let stable: Vec<f64> = scores
        .iter()
        .filter(|(_, is)| !is)
        .map(|(score, _)| score.max(SCORE_MIN).ln())
        .collect();
    ensure!(
        stable.len() >= 3,
        "could not fit slip to {} stable touches, needs 3 or more",
        stable.len()
    );
    let mean = stable.iter().sum::<f64>() / stable.len() as f64;
    let deviation = crate::statistics::deviation(&stable).context("a deviation")?;
    let threshold = (mean + CLEARANCE * deviation.max(DEVIATION_MIN)).exp();
    // Less than the noise is no motion.
    Ok(threshold.max(1.0))
}

/// Judges what was felt of every case.
pub(super) fn judge(
    cases: &[Case],
    sequences: &[Sequence],
    labels: &Labels,
    model: &Model,
    how: Fit,
) -> anyhow::Result<Verdict> {
    let truths = truths(cases, labels, &[], &model.slip.negative);
    let across = (how == Fit::Across).then_some(fit as Fitter);
    let threshold = model.slip.motion_at(rate_hz(sequences, &model.slip));
    let until = |until_s: f64| -> anyhow::Result<Vec<Scored>> {
        let scores: Vec<f64> = sequences
            .iter()
            .map(|sequence| score(&sequence.levels, until_s, &model.slip))
            .collect();
        decide(cases, &scores, &truths, threshold, across)
    };
    let mut verdict = Verdict::of(Judged::Slip, cases, &truths, how);
    ensure!(verdict.n > 0, "{}", no_labels());
    let rates = Rates::of(&until(f64::INFINITY)?);
    ensure!(
        rates.is_some(),
        "{}",
        one_class(&truths, ["slip", "stable"])
    );
    let levels = || sequences.iter().map(|sequence| &sequence.levels);
    let short = levels().filter(|levels| levels.is_empty()).count();
    ensure!(
        short < sequences.len(),
        "could not judge because no case is as long as two windows of {} s; which rows belong together is told by a column sequence, \
         sample or trial",
        model.slip.motion_window_s
    );
    let moves = levels().flatten().any(|level| level.level > 0.0);
    ensure!(
        moves,
        "could not judge because the readings have no noise, by which motion is measured; was the recording smoothed or rounded?"
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
        if let Some(rates) = Rates::of(&until(s)?) {
            verdict.after.push(After { s, rates });
        }
    }
    Ok(verdict)
}

/// The greatest motion of frames of forces, N, in multiples of their own noise: of a sensor that nothing touches, what a threshold
/// must lie above. 0 for what is too short to say.
#[must_use]
pub fn greatest_motion(frames: &[Vec<[f64; 3]>], step_s: f64) -> f64 {
    let elements = frames.first().map_or(1, Vec::len);
    let rate_hz = if step_s > 0.0 { 1.0 / step_s } else { 1.0 };
    let mut skin = Skin::new(1, elements, rate_hz, Settings::default());
    let mut greatest: f64 = 0.0;
    for frame in frames {
        let reading: Reading = frame.iter().copied().map(Some).collect();
        let motion = skin.feel(step_s, &[reading]).fingers[0].motion;
        greatest = greatest.max(motion.level);
    }
    greatest
}
