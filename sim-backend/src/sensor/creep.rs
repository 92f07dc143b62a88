//! Viscoelastic creep of one axis: a chain of Kelvin–Voigt elements.
//!
//! `y = g·(x + p·Σ z_i)`, `dz_i/dt = (x − z_i)/τ_i`, with τ = 0.1, 1, 10 and 100 s. Elements one
//! decade apart with equal compliance rise by p per decade of time, within ±8 %. The gain g makes
//! the reading exact 1 s after a step of the force, as in a calibration by weights.
//!
//! The update is exact for a force that is constant between samples.

/// Number of elements.
pub(crate) const ELEMENTS: usize = 4;
/// Time constants, s. Design choice: from the duration of a contact to that of a long hold.
const TIMES_S: [f64; ELEMENTS] = [0.1, 1.0, 10.0, 100.0];
/// Time after a step at which the reading is exact, s.
const REFERENCE_S: f64 = 1.0;

/// State of one axis: delayed forces, N.
pub(crate) type State = [f64; ELEMENTS];

/// Parameters, and the decay per sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Creep {
    /// Share of the distance to the force that an element covers per sample.
    step: [f64; ELEMENTS],
    gain: f64,
    /// Compliance of each element, with the gain.
    compliance: f64,
}

impl Creep {
    /// Returns the model for samples every `period_s` with a rise of `per_decade`.
    #[must_use]
    pub fn new(per_decade: f64, period_s: f64) -> Self {
        let covered = |time_s: f64| TIMES_S.map(|tau_s| -libm::expm1(-time_s / tau_s));
        let gain = 1.0 / (1.0 + per_decade * covered(REFERENCE_S).iter().sum::<f64>());
        Self {
            step: covered(period_s),
            gain,
            compliance: gain * per_decade,
        }
    }

    /// Returns the state before the first load.
    #[must_use]
    pub fn initial(&self) -> [f64; ELEMENTS] {
        [0.0; ELEMENTS]
    }

    /// Advances the state by one sample; returns the reading, N.
    #[inline]
    pub fn advance(&self, state: &mut [f64; ELEMENTS], force_n: f64) -> f64 {
        let mut sum_n = 0.0;
        for (delayed_n, step) in state.iter_mut().zip(self.step) {
            *delayed_n += step * (force_n - *delayed_n);
            sum_n += *delayed_n;
        }
        self.gain * force_n + self.compliance * sum_n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the reading of a force of 2 N, `time_s` after it began, over 2 N.
    fn step_response(creep: &Creep, period_s: f64, time_s: f64) -> f64 {
        let mut state = creep.initial();
        let samples = (time_s / period_s).round() as usize;
        let readings = (0..samples).map(|_| creep.advance(&mut state, 2.0));
        readings.last().expect("one sample") / 2.0
    }

    #[test]
    fn step_response_equals_the_closed_form() {
        for period_s in [0.001, 0.01] {
            let creep = Creep::new(0.05, period_s);
            for time_s in [0.1, 1.0, 7.0, 60.0] {
                let sum = |time_s: f64| -> f64 {
                    TIMES_S
                        .iter()
                        .map(|tau_s| 1.0 - (-time_s / tau_s).exp())
                        .sum()
                };
                let expected = (1.0 + 0.05 * sum(time_s)) / (1.0 + 0.05 * sum(1.0));
                let found = step_response(&creep, period_s, time_s);
                assert!(
                    (found - expected).abs() < 1e-9,
                    "{time_s} s: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn reading_rises_by_the_given_share_per_decade() {
        for per_decade in [0.05, 0.01, -0.02] {
            let creep = Creep::new(per_decade, 0.001);
            let at = |time_s| step_response(&creep, 0.001, time_s);
            assert!((at(1.0) - 1.0).abs() < 1e-9, "exact after 1 s");
            for from_s in [0.3, 1.0, 3.0] {
                let gain = creep.gain;
                let rise = (at(10.0 * from_s) - at(from_s)) / gain;
                assert!((rise / per_decade - 1.0).abs() < 0.1, "{from_s} s: {rise}");
            }
        }
    }

    #[test]
    fn unloaded_axis_recovers() {
        let creep = Creep::new(0.05, 0.01);
        let mut state = creep.initial();
        for _ in 0..1000 {
            creep.advance(&mut state, 1.0);
        }
        let first_n = creep.advance(&mut state, 0.0);
        let last_n = (0..100_000).map(|_| creep.advance(&mut state, 0.0)).last();
        assert!(
            first_n > 0.05 && last_n.is_some_and(|n| n.abs() < 1e-4),
            "{first_n} {last_n:?}"
        );
    }
}
