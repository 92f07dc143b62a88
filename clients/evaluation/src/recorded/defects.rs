//! Checks for unusable data: columns without numbers, constant columns, missing time, repeated
//! rows.
//!
//! A recording without usable data is rejected. Partial defects become warnings of the verdict.

use anyhow::ensure;

use super::kind::Kind;
use super::sheet::Sheet;
use super::steps::{TIMES, time_of};

/// Maximum number of columns named in a message.
const NAMED_COLUMNS_MAX: usize = 3;
/// Share of repeated rows that shows a sensor slower than the recording. Design choice: exceeded at
/// half the recording's rate, never by chance.
const HELD_SHARE: f64 = 0.4;

pub(super) fn check(sheet: &Sheet, kind: &Kind, rate_hz: f64) -> anyhow::Result<Vec<String>> {
    let mut warnings = Vec::new();
    for (what, columns) in kind.readings() {
        let (mut silent, mut still, mut holes) = (Vec::new(), Vec::new(), 0);
        for &column in &columns {
            let seen = ColumnRange::new(sheet, column);
            holes += if seen.numbers > 0 {
                sheet.len() - seen.numbers
            } else {
                0
            };
            match () {
                () if seen.numbers == 0 => silent.push(column),
                () if seen.numbers > 1 && seen.least == seen.most => still.push(column),
                () => {}
            }
        }
        let path = sheet.path.display();
        ensure!(
            silent.len() < columns.len(),
            "could not evaluate {path}: {what} ({}) has no number, but each row needs one; check \
             that the decimal sign is a point",
            column_list(sheet, &columns)
        );
        ensure!(
            silent.len() + still.len() < columns.len(),
            "could not evaluate {path}: {what} is constant ({}); check that the sensor was \
             connected",
            column_list(sheet, &still)
        );
        if !silent.is_empty() {
            warnings.push(format!(
                "no numbers in {}: ignored",
                column_list(sheet, &silent)
            ));
        }
        if !still.is_empty() {
            warnings.push(format!("constant values in {}", column_list(sheet, &still)));
        }
        if holes > 0 {
            let cells = sheet.len() * (columns.len() - silent.len());
            let share = 100.0 * holes as f64 / cells as f64;
            warnings.push(format!(
                "{holes} readings ({share:.1} %) are not numbers: ignored"
            ));
        }
    }
    warnings.extend(time_warning(sheet, rate_hz));
    Ok(warnings)
}

fn time_warning(sheet: &Sheet, rate_hz: f64) -> Option<String> {
    let Some((column, _)) = time_of(sheet) else {
        let names: Vec<&str> = TIMES.iter().map(|(name, _)| *name).collect();
        return Some(format!(
            "no time column ({}): {rate_hz} frames per second assumed; set another rate with \
             --rate-hz",
            names.join(", ")
        ));
    };
    let reported = ColumnRange::new(sheet, column).numbers;
    (reported < sheet.len()).then(|| {
        format!(
            "{} rows have no number in {}: one frame period after the previous row assumed",
            sheet.len() - reported,
            sheet.columns()[column]
        )
    })
}

/// Returns true if the sensor is slower than the recording.
pub(super) fn is_held(sheet: &Sheet, columns: &[usize]) -> bool {
    let repeats = (1..sheet.len())
        .filter(|&row| repeats(sheet, columns, row - 1, row))
        .count();
    repeats as f64 > HELD_SHARE * sheet.len() as f64
}

pub(super) fn repeats(sheet: &Sheet, columns: &[usize], before: usize, row: usize) -> bool {
    let same = |&column: &usize| sheet.text(before, column) == sheet.text(row, column);
    columns.iter().all(same)
}

struct ColumnRange {
    numbers: usize,
    least: f64,
    most: f64,
}

impl ColumnRange {
    fn new(sheet: &Sheet, column: usize) -> Self {
        let numbers = (0..sheet.len()).filter_map(|row| sheet.number(row, column));
        let none = Self {
            numbers: 0,
            least: f64::INFINITY,
            most: f64::NEG_INFINITY,
        };
        numbers.fold(none, |seen, number| Self {
            numbers: seen.numbers + 1,
            least: seen.least.min(number),
            most: seen.most.max(number),
        })
    }
}

fn column_list(sheet: &Sheet, columns: &[usize]) -> String {
    let names: Vec<&str> = columns
        .iter()
        .take(NAMED_COLUMNS_MAX)
        .map(|&column| sheet.columns()[column].as_str())
        .collect();
    let more = columns.len().saturating_sub(NAMED_COLUMNS_MAX);
    match more {
        0 => names.join(", "),
        more => format!("{} and {more} more", names.join(", ")),
    }
}
