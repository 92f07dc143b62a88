//! Percentiles and medians of measured durations.

/// Returns the given quantile of sorted values (nearest rank); 0 for an empty slice.
#[must_use]
pub fn quantile(sorted: &[u64], share: f64) -> u64 {
    let at = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(at.max(1) - 1).copied().unwrap_or(0)
}

/// Returns the median, the lower of two middle values; NaN for an empty vector.
#[must_use]
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let middle = values.len().saturating_sub(1) / 2;
    values.get(middle).copied().unwrap_or(f64::NAN)
}

/// Returns p50, p99, p99.9 and the maximum, µs, of durations in ns.
#[must_use]
pub fn microseconds(mut durations_ns: Vec<u64>) -> [f64; 4] {
    durations_ns.sort_unstable();
    [0.5, 0.99, 0.999, 1.0].map(|share| quantile(&durations_ns, share) as f64 * 1e-3)
}
