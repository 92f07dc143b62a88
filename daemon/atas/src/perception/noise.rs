//! How noisy the elements are, measured while the fingertip touches nothing.
//!
//! Lengths of noisy vectors are overrated, and so would be the friction that is read from them. What the sensor's own
//! silence says about its noise, after the same filter, takes that bias out again, whatever the sensor and its rate.

/// Time constant of the measurement, s (ours: a fraction of the slowest approach).
const FILTER_S: f64 = 0.3;

/// Running variance of the filtered tangential readings.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Noise {
    variance_n2: Option<f64>,
}

impl Noise {
    /// Variance of one tangential axis of one element, N²; 0 before anything was heard.
    pub(super) fn variance_n2(&self) -> f64 {
        self.variance_n2.unwrap_or(0.0)
    }

    /// Listens to the filtered elements of a fingertip that touches nothing, N.
    pub(super) fn listen(&mut self, elements_n: &[[f64; 3]], step_s: f64) {
        let sum: f64 = elements_n.iter().map(|[_, t1, t2]| t1 * t1 + t2 * t2).sum();
        let now_n2 = sum / (2 * elements_n.len()) as f64;
        let before_n2 = self.variance_n2.unwrap_or(now_n2);
        self.variance_n2 = Some(before_n2 + (now_n2 - before_n2) * step_s / (FILTER_S + step_s));
    }
}
