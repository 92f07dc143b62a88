//! Recording of one sensor as numbers: times, readings and, if known, the true force.

use anyhow::{Context, bail, ensure};
use atas_console::arguments::CalibrateModel;
use atas_evaluation::recorded::Sheet;

/// Names of the time column, each with its seconds per unit.
const TIMES: [(&str, f64); 4] = [
    ("t_s", 1.0),
    ("time_s", 1.0),
    ("t_s_approx", 1.0),
    ("captured_ns", 1e-9),
];
/// Name of the column with the true force, N.
const FORCE: &str = "force_n";
/// Fewest rows of a recording. Design choice: enough for a standard deviation within 15 %.
const ROWS_MIN: usize = 100;

/// Rows in order of time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Series {
    /// Time from the first row, s.
    pub(crate) time_s: Vec<f64>,
    /// Readings in the units of the recording, per row.
    pub(crate) readings: Vec<Vec<f64>>,
    /// True force, N; empty if the recording has none.
    pub(crate) force_n: Vec<f64>,
    /// First row of each group: rows of different groups are not connected in time.
    pub(crate) groups: Vec<usize>,
    /// True if the times come from the recording.
    pub(crate) has_times: bool,
}

impl Series {
    /// Reads the columns that the arguments name.
    pub(crate) fn read(sheet: &Sheet, arguments: &CalibrateModel) -> anyhow::Result<Self> {
        let path = sheet.path.display();
        let columns = reading_columns(sheet, &arguments.reading)?;
        let force = force_column(sheet, arguments.force.as_deref())?;
        let group = arguments.group.as_deref().map(|name| column(sheet, name));
        let group = group.transpose()?;
        let mut series = Self::default();
        let mut known = Vec::new();
        let time = TIMES
            .iter()
            .find_map(|(name, s)| Some((sheet.column(name)?, s)));
        for row in 0..sheet.len() {
            if group.is_some_and(|of| row == 0 || sheet.text(row, of) != sheet.text(row - 1, of)) {
                series.groups.push(row);
            }
            let values: Option<Vec<f64>> = columns.iter().map(|c| sheet.number(row, *c)).collect();
            let number = row + 1;
            series.readings.push(values.with_context(|| {
                format!("could not use row {number} of {path}: a reading is not a number; remove the row")
            })?);
            let time_s = match time {
                Some((column, unit)) => sheet.number(row, column).map(|time| time * unit),
                None => Some(row as f64 / arguments.rate_hz),
            };
            series.time_s.push(time_s.with_context(|| {
                format!(
                    "could not use row {number} of {path}: its time is not a number; remove the row"
                )
            })?);
            let value_n = force.and_then(|column| sheet.number(row, column));
            known.extend(value_n.map(|value| (row, value * arguments.force_unit)));
        }
        ensure!(
            sheet.len() >= ROWS_MIN,
            "could not fit a sensor model to {path}: it has {} rows, needs {ROWS_MIN}; record longer",
            sheet.len()
        );
        if series.groups.is_empty() {
            series.groups.push(0);
        }
        series.has_times = time.is_some();
        series.start_at_zero(&path.to_string())?;
        if force.is_some() {
            series.force_n = interpolated(&series.time_s, &known);
            ensure!(
                !known.is_empty(),
                "could not find a true force in {path}: its column has no number"
            );
        }
        Ok(series)
    }

    /// Moves the first time to zero; rejects times that decrease within a group.
    fn start_at_zero(&mut self, path: &str) -> anyhow::Result<()> {
        let first_s = self.time_s[0];
        self.time_s.iter_mut().for_each(|time_s| *time_s -= first_s);
        for group in self.ranges() {
            if !self.time_s[group].is_sorted() {
                bail!(
                    "could not use the times of {path}: they decrease; sort the rows, or name the column of separate recordings with --group"
                );
            }
        }
        Ok(())
    }

    /// Returns the rows of each group.
    pub(crate) fn ranges(&self) -> Vec<core::ops::Range<usize>> {
        let ends = self
            .groups
            .iter()
            .skip(1)
            .copied()
            .chain([self.time_s.len()]);
        self.groups
            .iter()
            .copied()
            .zip(ends)
            .map(|(from, to)| from..to)
            .collect()
    }

    /// Returns the usual time between rows, s.
    pub(crate) fn period_s(&self) -> f64 {
        let mut steps_s: Vec<f64> = Vec::new();
        for group in self.ranges() {
            steps_s.extend(self.time_s[group].windows(2).map(|pair| pair[1] - pair[0]));
        }
        atas_evaluation::median(steps_s).unwrap_or(0.0)
    }
}

fn column(sheet: &Sheet, name: &str) -> anyhow::Result<usize> {
    sheet.column(name).with_context(|| {
        format!(
            "could not find the column {name:?} in {}: it has {}",
            sheet.path.display(),
            sheet.columns().join(", ")
        )
    })
}

fn reading_columns(sheet: &Sheet, names: &[String]) -> anyhow::Result<Vec<usize>> {
    names.iter().map(|name| column(sheet, name)).collect()
}

/// Returns the column of the true force; without a name, `force_n` if it exists.
fn force_column(sheet: &Sheet, name: Option<&str>) -> anyhow::Result<Option<usize>> {
    match name {
        Some(name) => column(sheet, name).map(Some),
        None => Ok(sheet.column(FORCE)),
    }
}

/// Returns the force of every row; between known rows by linear interpolation in time.
fn interpolated(time_s: &[f64], known: &[(usize, f64)]) -> Vec<f64> {
    let of = |row: usize| {
        let after = known.partition_point(|(other, _)| *other < row);
        let (early, late) = match (after.checked_sub(1).map(|k| known[k]), known.get(after)) {
            (Some(early), Some(late)) => (early, *late),
            (Some(only), None) | (None, Some(&only)) => (only, only),
            (None, None) => return f64::NAN,
        };
        let span_s = time_s[late.0] - time_s[early.0];
        if span_s <= 0.0 {
            return late.1;
        }
        early.1 + (late.1 - early.1) * (time_s[row] - time_s[early.0]) / span_s
    };
    (0..time_s.len()).map(of).collect()
}
