//! Contacts of one fingertip, by the production contact detection with hysteresis.

use anyhow::{Context, ensure};
use atas_core::settings::Settings;

use super::cases::{Case, Labels};
use super::decision::{Fit, no_labels_error, one_class_error, truths};
use super::kind::Property;
use super::model::{Model, Touch};
use super::rates::{Rates, Scored};
use super::sheet::Sheet;
use super::skin::Skin;
use super::steps::steps_s;
use super::verdict::Verdict;

pub(super) struct Contacts {
    pub(super) begins: Vec<usize>,
    /// Row, normal force (N) and contact state per frame.
    pub(super) frames: Vec<(usize, f64, bool)>,
}

pub(super) fn measure(
    sheet: &Sheet,
    (axes, is_counts): ([usize; 3], bool),
    rows: &[usize],
    steps_s: &[f64],
    model: &Touch,
) -> anyhow::Result<Contacts> {
    let mut settings = Settings::default();
    for (name, value) in [
        ("perception.touch_off_n", 0.0),
        ("perception.touch_on_n", model.touch_on_n),
        ("perception.touch_off_n", model.touch_off_n),
        ("perception.filter_s", model.filter_s),
        ("intake.element_force_n", 100_000.0),
    ] {
        settings
            .set(name, value)
            .map_err(|error| anyhow::anyhow!("{error}"))?;
    }
    let mut skin = Skin::new(1, 1, model.rate_hz, settings);
    let mut measured = Contacts {
        begins: Vec::new(),
        frames: Vec::with_capacity(rows.len()),
    };
    let mut touches = 0;
    for (&row, &step_s) in rows.iter().zip(steps_s) {
        let value = |axis: usize| sheet.number(row, axes[axis]);
        let reading = match (value(0), value(1), value(2)) {
            (Some(x), Some(y), Some(z)) if is_counts => {
                let [sx, sy, sz] = model.newtons_per_count;
                // An OMD sensor reports negative z under axial pressure.
                Some([-z * sz, x * sx, y * sy])
            }
            (Some(n), Some(t1), Some(t2)) => Some([n, t1, t2]),
            _ => None,
        };
        let finger = skin.process(step_s, &[vec![reading]]).fingertips[0];
        if finger.touches != touches {
            touches = finger.touches;
            measured.begins.push(row);
        }
        measured
            .frames
            .push((row, finger.normal_n, finger.in_contact));
    }
    Ok(measured)
}

pub(super) fn evaluate(
    sheet: &Sheet,
    labels: &Labels,
    model: &Model,
    columns: ([usize; 3], bool),
) -> anyhow::Result<Verdict> {
    let rows: Vec<usize> = (0..sheet.len()).collect();
    let steps = steps_s(sheet, &rows, model.touch.rate_hz);
    let measured = measure(sheet, columns, &rows, &steps, &model.touch)?;
    let truth = match &labels.column {
        None => None,
        Some(name) => Some(sheet.column(name).with_context(|| {
            format!(
                "could not find the column {name:?}; the columns are {:?}",
                sheet.columns()
            )
        })?),
    };
    let cases: Vec<Case> = rows
        .iter()
        .map(|&row| Case {
            rows: vec![row],
            object: String::new(),
            category: String::new(),
            label: truth.map_or_else(String::new, |column| sheet.text(row, column).to_owned()),
        })
        .collect();
    let truths = truths(&cases, labels, &["touch".to_owned()], &["none".to_owned()]);
    let scored: Vec<Scored> = measured
        .frames
        .iter()
        .zip(&truths)
        .filter_map(|(&(_, score, message), truth)| {
            let is = (*truth)?;
            Some(Scored {
                score,
                decision: message,
                truth: is,
            })
        })
        .collect();
    let mut verdict = Verdict::with_counts(Property::Touch, &cases, &truths, Fit::Given);
    if truth.is_none() {
        (verdict.n, verdict.skipped) = (rows.len(), 0);
    }
    verdict.rates = Rates::from_cases(&scored);
    ensure!(verdict.n > 0, "{}", no_labels_error());
    ensure!(
        truth.is_none() || verdict.rates.is_some(),
        "{}",
        one_class_error(&truths, ["touch", "none"])
    );
    verdict.threshold = Some(model.touch.touch_on_n);
    verdict.touches = Some(measured.begins);
    Ok(verdict)
}
