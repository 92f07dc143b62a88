//! Median, standard deviation and confidence interval. Implemented here because `statrs` and
//! similar crates have no Wilson interval.

/// Two-sided 95 % quantile of the normal distribution.
const Z_95: f64 = 1.959_963_984_540_054;

/// Returns the middle value, or the mean of the two middle values.
#[must_use]
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let upper = values.len() / 2;
    match values.len() {
        0 => None,
        odd if odd % 2 == 1 => Some(values[upper]),
        _ => Some((values[upper - 1] + values[upper]) / 2.0),
    }
}

pub(super) fn deviation(values: &[f64]) -> Option<f64> {
    if values.len() < 2 {
        return None;
    }
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    Some((squares / (count - 1.0)).sqrt())
}

/// Returns the 95 % Wilson score interval of a share (Wilson 1927); [0, 1] without trials.
///
/// ```
/// let [low, high] = atas_evaluation::wilson(97, 100);
/// assert!(low < 0.97 && 0.97 < high);
/// ```
#[must_use]
pub fn wilson(successes: u64, trials: u64) -> [f64; 2] {
    if trials == 0 {
        return [0.0, 1.0];
    }
    let (n, p) = (trials as f64, successes as f64 / trials as f64);
    let z2 = Z_95 * Z_95;
    let centre = p + z2 / (2.0 * n);
    let half = Z_95 * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
    let scale = 1.0 / (1.0 + z2 / n);
    [
        ((centre - half) * scale).max(0.0),
        ((centre + half) * scale).min(1.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wilson_interval_matches_r() {
        let check = |successes, trials, expected: [f64; 2]| {
            let interval = wilson(successes, trials);
            let near = |side: usize| (interval[side] - expected[side]).abs() < 1e-4;
            assert!(near(0) && near(1), "{successes}/{trials}: {interval:?}");
        };
        // Values from R's binom::binom.confint(method = "wilson").
        check(0, 0, [0.0, 1.0]);
        check(0, 10, [0.0, 0.2775]);
        check(10, 10, [0.7225, 1.0]);
        check(5, 10, [0.2366, 0.7634]);
        check(599, 600, [0.9906, 0.9997]);
    }

    #[test]
    fn median_and_deviation_of_small_samples() {
        let check = |values: &[f64], expected_median, expected_deviation: Option<f64>| {
            assert_eq!(median(values.to_vec()), expected_median, "{values:?}");
            assert_eq!(deviation(values), expected_deviation, "{values:?}");
        };
        check(&[], None, None);
        check(&[3.0], Some(3.0), None);
        check(&[3.0, 1.0], Some(2.0), Some(2.0_f64.sqrt()));
        check(&[3.0, 1.0, 2.0], Some(2.0), Some(1.0));
    }
}
