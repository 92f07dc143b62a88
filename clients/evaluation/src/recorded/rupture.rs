//! Rupture force of a pressed object, predicted from the force at which it begins to yield.

use std::collections::BTreeMap;

use anyhow::{Context, ensure};
use atas_core::perception::{YieldDetector, YieldRule};
use atas_core::settings::Settings;

use super::cases::Case;
use super::decision::{Fit, no_labels_error};
use super::kind::Property;
use super::model::{Line, Model, Rupture};
use super::sheet::Sheet;
use super::skin::Skin;
use super::verdict::{Errors, Verdict};
use crate::statistics::median;

/// Time constants of the low-pass before evaluation starts, for a recording that begins in
/// mid-press. Design choice: 1 % of the transient remains.
const SETTLING_TIME_CONSTANTS: f64 = 5.0;

pub(super) fn peak_n(
    sheet: &Sheet,
    (force, position): (usize, usize),
    rows: &[usize],
    steps_s: &[f64],
    model: &Rupture,
) -> anyhow::Result<f64> {
    let mut settings = Settings::default();
    settings
        .set("perception.filter_s", model.filter_s)
        .map_err(|error| anyhow::anyhow!("{error}"))?;
    let mut skin = Skin::new(1, 1, model.rate_hz, settings);
    let mut watch = YieldDetector::new(YieldRule {
        from_n: model.from_n,
        window_n: model.window_n,
        share: model.share,
    });
    let (mut late_m, mut at_s) = (None, 0.0);
    for (&row, &step_s) in rows.iter().zip(steps_s) {
        let (Some(force_n), Some(position_mm)) =
            (sheet.number(row, force), sheet.number(row, position))
        else {
            continue;
        };
        let percept = *skin.process(step_s, &[vec![Some([force_n, 0.0, 0.0])]]);
        // Filters the position with the same low-pass as the force, so that both have the same
        // delay.
        let now_m = position_mm * 1e-3;
        let share = percept.step_s / (model.filter_s + percept.step_s).max(f64::MIN_POSITIVE);
        let before_m = late_m.unwrap_or(now_m);
        let closing_m = before_m + (now_m - before_m) * share;
        late_m = Some(closing_m);
        at_s += step_s;
        if at_s < SETTLING_TIME_CONSTANTS * model.filter_s {
            continue;
        }
        if watch
            .add(closing_m, percept.fingertips[0].normal_n)
            .is_some()
        {
            break;
        }
    }
    Ok(watch.maxima().peak_n)
}

/// Predicts the rupture force from the peak force, N. Without a line for this category it returns
/// the peak.
pub(super) fn predict_n(lines: &BTreeMap<String, Line>, sort: &str, peak_n: f64) -> f64 {
    lines
        .get(sort)
        .map_or(peak_n, |line| line.offset_n + line.slope * peak_n)
}

/// Fits one least-squares line per category.
pub(super) fn fit(cases: &[(&str, f64, f64)]) -> anyhow::Result<BTreeMap<String, Line>> {
    let mut sorts: BTreeMap<&str, Vec<(f64, f64)>> = BTreeMap::new();
    for &(sort, peak_n, truth_n) in cases {
        sorts.entry(sort).or_default().push((peak_n, truth_n));
    }
    let line = |(sort, points): (&str, Vec<(f64, f64)>)| {
        let count = points.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
        let (x, y) = (mean(|p| p.0), mean(|p| p.1));
        let spread: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
        let along: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
        ensure!(
            points.len() >= 3 && spread > 0.0,
            "could not fit the rupture of {sort:?}: {} presses with mean force {x:.2} N, but 3 or \
             more with different forces are needed",
            points.len()
        );
        let slope = along / spread;
        let offset_n = y - slope * x;
        Ok((sort.to_owned(), Line { offset_n, slope }))
    };
    sorts.into_iter().map(line).collect()
}

pub(super) fn points<'a>(
    cases: &'a [Case],
    peaks_n: &'a [f64],
) -> impl Iterator<Item = (&'a str, f64, f64)> {
    cases.iter().zip(peaks_n).filter_map(|(case, &peak_n)| {
        let truth_n: f64 = case.label.parse().ok()?;
        truth_n
            .is_finite()
            .then_some((case.category.as_str(), peak_n, truth_n))
    })
}

pub(super) fn evaluate(
    cases: &[Case],
    peaks_n: &[f64],
    model: &Model,
    how: Fit,
) -> anyhow::Result<Verdict> {
    let points: Vec<_> = points(cases, peaks_n).collect();
    ensure!(!points.is_empty(), "{}", no_labels_error());
    ensure!(
        points.iter().any(|(_, peak_n, _)| *peak_n > 0.0),
        "could not evaluate: no press exceeded {} N; check that the forces are in newtons",
        model.rupture.from_n
    );
    let truths: Vec<Option<bool>> = cases
        .iter()
        .map(|case| {
            case.label
                .parse::<f64>()
                .is_ok_and(f64::is_finite)
                .then_some(true)
        })
        .collect();
    let judged: Vec<&Case> = cases
        .iter()
        .zip(&truths)
        .filter_map(|(case, truth)| truth.map(|_| case))
        .collect();
    let mut sorts: BTreeMap<String, Vec<[f64; 3]>> = BTreeMap::new();
    for (index, &(sort, peak_n, truth_n)) in points.iter().enumerate() {
        let others: Vec<_> = (0..points.len())
            .filter(|&other| {
                judged[other].object != judged[index].object && points[other].0 == sort
            })
            .map(|other| points[other])
            .collect();
        let own: BTreeMap<String, Line>;
        let lines = match how {
            Fit::Given => &model.rupture.lines,
            Fit::Across => {
                own = fit(&others)
                    .with_context(|| format!("leaving out {:?}", judged[index].object))?;
                &own
            }
        };
        let mean_n = others.iter().map(|other| other.2).sum::<f64>() / others.len().max(1) as f64;
        sorts.entry(sort.to_owned()).or_default().push([
            (predict_n(lines, sort, peak_n) - truth_n).abs(),
            (mean_n - truth_n).abs(),
            peak_n - truth_n,
        ]);
    }
    let mut verdict = Verdict::with_counts(Property::Rupture, cases, &truths, how);
    let all: Vec<[f64; 3]> = sorts.values().flatten().copied().collect();
    verdict.mae_n = Some(mean(&all, 0));
    let errors = |errors: Vec<[f64; 3]>| Errors {
        n: errors.len(),
        mae_n: mean(&errors, 0),
        mae_of_mean_n: mean(&errors, 1),
        beyond_n: median(errors.iter().map(|error| error[2]).collect()).unwrap_or(f64::NAN),
    };
    let by_sort = sorts.into_iter();
    verdict.sorts = by_sort.map(|(sort, of)| (sort, errors(of))).collect();
    Ok(verdict)
}

fn mean(errors: &[[f64; 3]], of: usize) -> f64 {
    errors.iter().map(|error| error[of]).sum::<f64>() / errors.len() as f64
}
