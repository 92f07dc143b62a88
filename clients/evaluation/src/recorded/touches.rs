//! Contacts of one fingertip, by the production contact detection with hysteresis.

use anyhow::{Context, ensure};
use atas_core::settings::Settings;

use super::cases::{Case, Labels};
use super::decision::{Fit, no_labels, one_class, truths};
use super::kind::Judged;
use super::model::{Model, Touch};
use super::rates::{Rates, Scored};
use super::sheet::Sheet;
use super::skin::Skin;
use super::steps::steps_s;
use super::verdict::Verdict;

pub(super) struct Felt {
    pub(super) begins: Vec<usize>,
    /// Row, normal force (N) and contact state per frame.
    pub(super) frames: Vec<(usize, f64, bool)>,
}

pub(super) fn feel(
    sheet: &Sheet,
    (axes, is_counts): ([usize; 3], bool),
    rows: &[usize],
    steps_s: &[f64],
    model: &Touch,
) -> anyhow::Result<Felt> {
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
    let mut felt = Felt {
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
        let finger = skin.feel(step_s, &[vec![reading]]).fingers[0];
        if finger.touches != touches {
            touches = finger.touches;
            felt.begins.push(row);
        }
        felt.frames.push((row, finger.normal_n, finger.in_contact));
    }
    Ok(felt)
}

pub(super) fn judge(
    sheet: &Sheet,
    labels: &Labels,
    model: &Model,
    columns: ([usize; 3], bool),
) -> anyhow::Result<Verdict> {
    let rows: Vec<usize> = (0..sheet.len()).collect();
    let steps = steps_s(sheet, &rows, model.touch.rate_hz);
    let felt = feel(sheet, columns, &rows, &steps, &model.touch)?;
    let truth = match &labels.column {
        None => None,
        Some(name) => Some(sheet.column(name).with_context(|| {
            format!(
                "could not find the column {name:?}; there are {:?}",
                sheet.columns()
            )
        })?),
    };
    let cases: Vec<Case> = rows
        .iter()
        .map(|&row| Case {
            rows: vec![row],
            object: String::new(),
            sort: String::new(),
            label: truth.map_or_else(String::new, |column| sheet.text(row, column).to_owned()),
        })
        .collect();
    let truths = truths(&cases, labels, &["touch".to_owned()], &["none".to_owned()]);
    let scored: Vec<Scored> = felt
        .frames
        .iter()
        .zip(&truths)
        .filter_map(|(&(_, score, said), truth)| {
            let is = (*truth)?;
            Some(Scored { score, said, is })
        })
        .collect();
    let mut verdict = Verdict::of(Judged::Touch, &cases, &truths, Fit::Given);
    if truth.is_none() {
        (verdict.n, verdict.skipped) = (rows.len(), 0);
    }
    verdict.rates = Rates::of(&scored);
    ensure!(verdict.n > 0, "{}", no_labels());
    ensure!(
        truth.is_none() || verdict.rates.is_some(),
        "{}",
        one_class(&truths, ["touch", "none"])
    );
    verdict.threshold = Some(model.touch.touch_on_n);
    verdict.touches = Some(felt.begins);
    Ok(verdict)
}
