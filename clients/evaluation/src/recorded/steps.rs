//! Frame periods of a recording.

use super::sheet::Sheet;
use super::skin::RATE_MAX_HZ;
use crate::statistics::median;

/// Known time columns with their units in s; the first that exists is used.
pub(super) const TIMES: [(&str, f64); 9] = [
    ("t_s", 1.0),
    ("time_s", 1.0),
    ("timestamp_s", 1.0),
    ("t_s_approx", 1.0),
    ("t_ms", 1e-3),
    ("time_ms", 1e-3),
    ("t_us", 1e-6),
    ("t_ns", 1e-9),
    ("captured_ns", 1e-9),
];

pub(super) fn time_of(sheet: &Sheet) -> Option<(usize, f64)> {
    let known = TIMES.iter();
    known
        .filter_map(|(name, unit_s)| Some((sheet.column(name)?, *unit_s)))
        .next()
}

/// Returns the frame periods, s, from the time column or `rate_hz`. Non-increasing time counts as
/// one default period. A median rate above [`RATE_MAX_HZ`] means stamps of a decoded file: all
/// periods are the default.
pub(super) fn steps_s(sheet: &Sheet, rows: &[usize], rate_hz: f64) -> Vec<f64> {
    let column = time_of(sheet);
    let usual_s = 1.0 / rate_hz;
    let time_s = |row: usize| {
        let (column, unit_s) = column?;
        Some(sheet.number(row, column)? * unit_s)
    };
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
