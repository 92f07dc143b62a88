//! Figures of a sensor that need no reference: resolution, noise and range.

use super::series::Series;

/// Rows per window in which noise is measured. Design choice: long enough for a standard deviation
/// within 15 %, short enough to contain no slow motion.
const WINDOW: usize = 25;
/// Share of the quietest windows that count as noise. Design choice: a recording needs a tenth of
/// its time without motion.
const QUIET_SHARE: f64 = 0.1;
/// Fewest equal extreme rows in sequence that count as saturation. Design choice: noise of one step
/// makes such a run unlikely.
const SATURATED_ROWS: usize = 10;

/// Figures of one column of readings, in its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Column {
    /// Smallest difference of two values; 0 if all are equal.
    pub(super) step: f64,
    /// Standard deviation in the quietest windows.
    pub(super) noise: f64,
    /// Largest magnitude.
    pub(super) largest: f64,
    /// True if the sensor stays at the largest magnitude.
    pub(super) saturates: bool,
}

impl Column {
    pub(super) fn measure(series: &Series, column: usize) -> Self {
        let values: Vec<f64> = series.readings.iter().map(|row| row[column]).collect();
        let largest = values
            .iter()
            .fold(0.0_f64, |most, value| most.max(value.abs()));
        Self {
            step: step(&values, largest),
            noise: noise(series, &values, largest),
            largest,
            saturates: stays_at(&values, largest),
        }
    }
}

/// Returns the smallest difference of distinct values; rounding errors of text do not count.
fn step(values: &[f64], largest: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rounding = 1e-6 * largest;
    let differences = sorted.windows(2).map(|pair| pair[1] - pair[0]);
    differences
        .filter(|difference| *difference > rounding)
        .min_by(f64::total_cmp)
        .unwrap_or(0.0)
}

/// Returns the noise: the median of the quietest windows' deviations from their own trend. Windows
/// that touch the largest magnitude do not count, because a saturated sensor has no noise.
fn noise(series: &Series, values: &[f64], largest: f64) -> f64 {
    let mut deviations = Vec::new();
    for group in series.ranges() {
        for window in values[group].chunks_exact(WINDOW) {
            if window.iter().all(|value| value.abs() < largest) {
                deviations.push(deviation_from_trend(window));
            }
        }
    }
    deviations.sort_by(f64::total_cmp);
    let quiet = ((QUIET_SHARE * deviations.len() as f64).ceil() as usize).max(1);
    deviations
        .get(quiet.min(deviations.len()).saturating_sub(1) / 2)
        .copied()
        .unwrap_or(0.0)
}

/// Returns the standard deviation around the line of least squares.
pub(super) fn deviation_from_trend(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let middle = (count - 1.0) / 2.0;
    let (mut along, mut square) = (0.0, 0.0);
    for (index, value) in values.iter().enumerate() {
        let x = index as f64 - middle;
        along += x * (value - mean);
        square += x * x;
    }
    let slope = if square > 0.0 { along / square } else { 0.0 };
    let rest = |(index, value): (usize, &f64)| value - mean - slope * (index as f64 - middle);
    let squares: f64 = values
        .iter()
        .enumerate()
        .map(rest)
        .map(|rest| rest * rest)
        .sum();
    (squares / (count - 2.0).max(1.0)).sqrt()
}

fn stays_at(values: &[f64], largest: f64) -> bool {
    let mut run = 0;
    values.iter().any(|value| {
        run = if value.abs() == largest { run + 1 } else { 0 };
        run >= SATURATED_ROWS && largest > 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim_backend::random::Random;

    fn series(values: &[f64]) -> Series {
        Series {
            time_s: (0..values.len()).map(|row| row as f64 * 0.01).collect(),
            readings: values.iter().map(|value| vec![*value]).collect(),
            groups: vec![0],
            ..Series::default()
        }
    }

    #[test]
    fn noise_step_and_range_are_recovered() {
        let mut random = Random::new(3, 1);
        // Rest, then a slow press into saturation, then rest.
        let truth = |row: usize| (8.0 - (row as f64 - 1000.0).abs() / 50.0).max(0.0);
        let values: Vec<f64> = (0..2000)
            .map(|row| {
                let value = truth(row) + 0.02 * random.gaussian();
                ((value / 0.005).round() * 0.005).min(6.0)
            })
            .collect();
        let found = Column::measure(&series(&values), 0);
        assert!((found.step - 0.005).abs() < 1e-9, "{found:?}");
        assert!((found.noise / 0.02 - 1.0).abs() < 0.35, "{found:?}");
        assert!(
            (found.largest - 6.0).abs() < 1e-9 && found.saturates,
            "{found:?}"
        );
    }

    #[test]
    fn peak_without_plateau_is_no_saturation() {
        let values: Vec<f64> = (0..500).map(|row| f64::from(row % 100) * 0.1).collect();
        let found = Column::measure(&series(&values), 0);
        assert!(!found.saturates);
        assert!(
            (found.step - 0.1).abs() < 1e-9 && found.noise < 1e-9,
            "{found:?}"
        );
    }
}
