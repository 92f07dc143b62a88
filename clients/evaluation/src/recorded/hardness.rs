//! Classification of squeezes as hard or soft by the production stiffness probe on all fingers
//! together.

use anyhow::ensure;
use atas_core::perception::{LoadedArea, StiffnessEstimate};
use atas_core::settings::Settings;
use robot_model::Compression;

use super::cases::{Case, Labels};
use super::decision::{Fit, Fitter, decide, no_labels_error, one_class_error, truths};
use super::kind::Property;
use super::model::{Hardness, Model};
use super::rates::Rates;
use super::sheet::Sheet;
use super::skin::{Reading, Skin};
use super::verdict::Verdict;

/// Frames at the beginning without contact, after which the sensor bias is set. Design choice.
const BIAS_FRAMES: usize = 4;
/// Sides that share the squeeze force.
const SIDES: f64 = 2.0;
/// The compression of these fingertips is unknown; rigid fingertips are assumed.
const RIGID_TIPS: Compression = Compression {
    at_1n_m: 1e-6,
    exponent: 0.48,
};
/// The contact area is also unknown; full faces are assumed.
const WHOLE_FACES: [LoadedArea; 2] = [LoadedArea::WHOLE; 2];
/// Smallest closing for a stiffness estimate, m. Design choice: resolution of an actuator's
/// encoder.
const CLOSING_MIN_M: f64 = 1e-5;

/// Stiffness per side, N/m; 0 without contact or without an estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SqueezeStiffness {
    pub(super) whole_n_m: f64,
    /// Estimate including the first frame after contact.
    pub(super) first_step_n_m: f64,
}

pub(super) fn measure(
    sheet: &Sheet,
    (forces, angles): (&[[usize; 3]], &[usize]),
    rows: &[usize],
    steps_s: &[f64],
    model: &Hardness,
) -> anyhow::Result<SqueezeStiffness> {
    let settings = settings(model)?;
    let probe_settings = settings.perception;
    let mut skin = Skin::new(forces.len(), 1, model.rate_hz, settings);
    let mut probe = StiffnessEstimate::default();
    let mut measured = SqueezeStiffness::default();
    let (mut after_touch, mut before) = (0, None);
    for (frame, (&row, &step_s)) in rows.iter().zip(steps_s).enumerate() {
        let readings: Vec<Reading> = forces
            .iter()
            .map(|&axes| vec![read_force(sheet, row, axes)])
            .collect();
        let percept = *skin.process(step_s, &readings);
        if frame < BIAS_FRAMES {
            skin.bias();
            continue;
        }
        let total_n: f64 = percept.fingertips[..forces.len()]
            .iter()
            .map(|finger| finger.force_tip_n.norm())
            .sum();
        let face_n = total_n / SIDES;
        let Some(closing_m) = closing_m(sheet, row, angles, model.lever_m) else {
            continue;
        };
        if let Some(fit) = probe.add(
            closing_m,
            face_n,
            percept.step_s,
            &RIGID_TIPS,
            WHOLE_FACES.into(),
            &probe_settings,
        ) {
            measured.whole_n_m = fit.object_n_m;
        }
        // The first frame with contact is number 1; the step after contact ends with number 2.
        if after_touch < 2 && (after_touch > 0 || face_n > model.touch_on_n) {
            after_touch += 1;
            measured.first_step_n_m = if measured.whole_n_m > 0.0 {
                measured.whole_n_m
            } else {
                chord_n_m(before, (closing_m, face_n))
            };
        } else if after_touch == 0 {
            before = Some((closing_m, face_n));
        }
    }
    Ok(measured)
}

/// Returns the stiffness since the last frame without contact, for objects too stiff for three
/// probe frames.
fn chord_n_m(before: Option<(f64, f64)>, (closing_m, face_n): (f64, f64)) -> f64 {
    before.map_or(0.0, |(before_m, before_n)| {
        let closed_m = (closing_m - before_m).max(CLOSING_MIN_M);
        SIDES * (face_n - before_n).max(0.0) / closed_m
    })
}

fn settings(model: &Hardness) -> anyhow::Result<Settings> {
    let mut settings = Settings::default();
    for (name, value) in [
        ("perception.touch_off_n", 0.0),
        ("perception.touch_on_n", model.touch_on_n),
        ("perception.touch_off_n", model.touch_off_n),
        ("perception.filter_s", model.filter_s),
    ] {
        settings
            .set(name, value)
            .map_err(|error| anyhow::anyhow!("{error}"))?;
    }
    Ok(settings)
}

/// Reads x, y, z as tangential and normal axes of one element; only the magnitude is used.
fn read_force(sheet: &Sheet, row: usize, [x, y, z]: [usize; 3]) -> Option<[f64; 3]> {
    Some([
        sheet.number(row, z)?,
        sheet.number(row, x)?,
        sheet.number(row, y)?,
    ])
}

fn closing_m(sheet: &Sheet, row: usize, angles: &[usize], lever_m: f64) -> Option<f64> {
    let message: Vec<f64> = angles
        .iter()
        .filter_map(|&column| sheet.number(row, column))
        .collect();
    let mean_deg = message.iter().sum::<f64>() / message.len() as f64;
    (!message.is_empty()).then(|| mean_deg.to_radians() * lever_m)
}

/// Fits the threshold: geometric mean of the mean stiffness of hard and of soft objects.
pub(super) fn fit(scores: &[(f64, bool)]) -> anyhow::Result<f64> {
    let mean = |class: bool| {
        let of: Vec<f64> = scores
            .iter()
            .filter(|(score, is)| *is == class && *score > 0.0)
            .map(|(score, _)| score.ln())
            .collect();
        let mean = of.iter().sum::<f64>() / of.len() as f64;
        (!of.is_empty()).then_some(mean)
    };
    let (hard, soft) = (mean(true), mean(false));
    ensure!(
        hard.is_some() && soft.is_some(),
        "could not fit hardness: no {} object has a measured stiffness; both classes are needed",
        if hard.is_none() { "hard" } else { "soft" }
    );
    Ok((0.5 * (hard.unwrap_or(0.0) + soft.unwrap_or(0.0))).exp())
}

pub(super) fn evaluate(
    cases: &[Case],
    measured: &[SqueezeStiffness],
    labels: &Labels,
    model: &Model,
    how: Fit,
) -> anyhow::Result<Verdict> {
    let model = &model.hardness;
    let truths = truths(cases, labels, &model.positive, &model.negative);
    let across = (how == Fit::Across).then_some(fit as Fitter);
    let rates = |of: fn(&SqueezeStiffness) -> f64, threshold: f64| -> anyhow::Result<_> {
        let scores: Vec<f64> = measured.iter().map(of).collect();
        Ok(Rates::from_cases(&decide(
            cases, &scores, &truths, threshold, across,
        )?))
    };
    let mut verdict = Verdict::with_counts(Property::Hardness, cases, &truths, how);
    ensure!(verdict.n > 0, "{}", no_labels_error());
    verdict.rates = rates(|measured| measured.whole_n_m, model.whole_n_m)?;
    ensure!(
        verdict.rates.is_some(),
        "{}",
        one_class_error(&truths, ["hard", "soft"])
    );
    let untouched = measured
        .iter()
        .filter(|measured| **measured == SqueezeStiffness::default())
        .count();
    ensure!(
        untouched < measured.len(),
        "could not evaluate: no squeeze exceeded {} N per side; check that the forces are in \
         newtons, or set a lower hardness.touch_on_n with --model",
        model.touch_on_n
    );
    if untouched > 0 {
        verdict.warnings.push(format!(
            "{untouched} of {} squeezes did not exceed {} N per side and count as soft",
            measured.len(),
            model.touch_on_n
        ));
    }
    verdict.first_step = rates(|measured| measured.first_step_n_m, model.first_step_n_m)?;
    verdict.threshold = Some(model.whole_n_m);
    Ok(verdict)
}
