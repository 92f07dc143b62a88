//! Filters for noisy readings: first-order low-pass and dwell time.

/// Returns the low-passed value after `step_s`, s, with time constant `filter_s`, s (backward
/// Euler: stable for any step).
pub(crate) fn low_pass(before: f64, now: f64, step_s: f64, filter_s: f64) -> f64 {
    before + (now - before) * step_s / (filter_s + step_s)
}

/// Time for which a condition has held without interruption.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Dwell {
    held_s: f64,
}

impl Dwell {
    /// A condition that has always held.
    pub(crate) const FOREVER: Self = Self {
        held_s: f64::INFINITY,
    };

    /// Adds a tick of `step_s`, s, in which the condition holds or not.
    pub(crate) fn update(&mut self, holds: bool, step_s: f64) {
        self.held_s = if holds { self.held_s + step_s } else { 0.0 };
    }

    /// Returns the time, s; 0 while the condition does not hold.
    pub(crate) fn seconds(self) -> f64 {
        self.held_s
    }
}

#[cfg(test)]
mod tests {
    use super::{Dwell, low_pass};

    #[test]
    fn dwell_restarts_when_the_condition_fails() {
        let mut dwell = Dwell::default();
        let times_s = [true, true, false, true].map(|holds| {
            dwell.update(holds, 0.5);
            dwell.seconds()
        });
        assert_eq!(times_s, [0.5, 1.0, 0.0, 0.5]);
        let mut always = Dwell::FOREVER;
        always.update(true, 0.5);
        assert_eq!(always.seconds(), f64::INFINITY);
    }

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
