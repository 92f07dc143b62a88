//! First-order low-pass for noisy readings.

/// Returns the low-passed value after `step_s`, s, with time constant `filter_s`, s (backward
/// Euler: stable for any step).
pub(crate) fn low_pass(before: f64, now: f64, step_s: f64, filter_s: f64) -> f64 {
    before + (now - before) * step_s / (filter_s + step_s)
}

#[cfg(test)]
mod tests {
    use super::low_pass;

    #[test]
    fn low_pass_approaches_the_input_without_overshoot() {
        for (before, now, step_s, filter_s, expected) in [
            (0.0, 1.0, 1.0, 1.0, 0.5),
            (2.0, 1.0, 1.0, 3.0, 1.75),
            (0.0, 1.0, 1.0, 0.0, 1.0),
            (3.0, 3.0, 0.001, 0.1, 3.0),
        ] {
            assert_eq!(low_pass(before, now, step_s, filter_s), expected);
        }
    }
}
