//! Noise of the elements, measured while the fingertip is unloaded.
//!
//! Noise increases vector lengths and hence the friction reading; the measured noise corrects this
//! bias. Only changes between frames count: an offset or a slow load below the contact threshold is
//! not noise.

use crate::filter::low_pass;

/// Time constant of the measurement, s (design choice: a fraction of the slowest approach).
const FILTER_S: f64 = 0.3;

/// Running variance of the filtered tangential readings.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Noise {
    variance_n2: Option<f64>,
    /// The previous frame was unloaded too, so that the change since it is noise.
    continues: bool,
}

impl Noise {
    /// Variance of one tangential axis of one element, N²; 0 before the first measurement.
    pub(super) fn variance_n2(&self) -> f64 {
        self.variance_n2.unwrap_or(0.0)
    }

    /// Adds a frame of an unloaded fingertip. `change_n2` is the sum of the squared changes of all
    /// filtered tangential readings of `count` elements, N². `share` is the filter gain;
    /// differences of filtered white noise have 2·share times its variance.
    pub(super) fn update(&mut self, change_n2: f64, count: usize, share: f64, step_s: f64) {
        let continues = core::mem::replace(&mut self.continues, true);
        if continues && share > 0.0 {
            let now_n2 = change_n2 / (2 * count) as f64 / (2.0 * share);
            let old_n2 = self.variance_n2.unwrap_or(now_n2);
            self.variance_n2 = Some(low_pass(old_n2, now_n2, step_s, FILTER_S));
        }
    }

    /// Interrupts the measurement during contact.
    pub(super) fn pause(&mut self) {
        self.continues = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Share of a 5 ms filter at 1 kHz.
    const SHARE: f64 = 1.0 / 6.0;

    /// Standard deviation measured in one second of readings, N.
    fn measured_n(reading_n: impl Fn(usize) -> f64) -> f64 {
        let mut noise = Noise::default();
        for index in 0..1000_usize {
            let change_n = reading_n(index) - reading_n(index.saturating_sub(1));
            noise.update(2.0 * change_n * change_n, 1, SHARE, 1e-3);
        }
        noise.variance_n2().sqrt()
    }

    /// Regression: a light load below the contact threshold of a real fingertip counted as noise
    /// and hid contacts.
    #[test]
    fn offsets_and_slow_loads_are_not_noise() {
        assert_eq!(measured_n(|_| 5.0), 0.0);
        let ramp_n = measured_n(|index| 0.01 * index as f64);
        assert!(ramp_n < 0.02, "{ramp_n} N from a ramp of 10 N/s");
    }

    #[test]
    fn alternating_readings_are_noise() {
        let flicker = |index: usize| if index.is_multiple_of(2) { 0.01 } else { -0.01 };
        let received = measured_n(flicker);
        // Differences of 20 mN per axis, over 2·share.
        assert!(
            (received - 0.02 / (2.0 * SHARE).sqrt()).abs() < 1e-3,
            "{received}"
        );
        let mut paused = Noise::default();
        for index in 0..10 {
            paused.update(flicker(index) * flicker(index), 1, SHARE, 1e-3);
            paused.pause();
        }
        assert_eq!(
            paused.variance_n2(),
            0.0,
            "contacts in between must suspend the measurement"
        );
    }
}
