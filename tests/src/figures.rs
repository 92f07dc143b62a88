//! Percentiles and medians of measured durations.

/// The smallest value that so large a share of sorted values does not exceed; 0 of none.
#[must_use]
pub fn rank(sorted: &[u64], share: f64) -> u64 {
    let at = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(at.max(1) - 1).copied().unwrap_or(0)
}

/// The middle of some numbers, the lower one of two; NaN of none.
#[must_use]
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let middle = values.len().saturating_sub(1) / 2;
    values.get(middle).copied().unwrap_or(f64::NAN)
}

/// p50, p99, p99.9 and the largest of durations in ns, µs.
#[must_use]
pub fn microseconds(mut durations_ns: Vec<u64>) -> [f64; 4] {
    durations_ns.sort_unstable();
    [0.5, 0.99, 0.999, 1.0].map(|share| rank(&durations_ns, share) as f64 * 1e-3)
}
