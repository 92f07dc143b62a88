//! Unloaded sensor: zero, noise, drift, and resulting contact thresholds.

use serde::Serialize;

use super::{AXES, Calibration};

/// Minimum frames of a noise estimate. Design choice: standard deviation within 10 %.
pub(super) const FRAMES_MIN: usize = 50;

/// Standard deviations of a significant change. Design choice.
pub(super) const SIGNIFICANT_SIGMAS: f64 = 3.0;

/// Zero and noise of an unloaded sensor, in device units.
#[derive(Clone, Debug, PartialEq)]
pub struct Silence {
    /// Mean per value.
    pub zero: Vec<f64>,
    /// Standard deviation per value, without slow changes.
    pub noise: Vec<f64>,
}

/// Contact thresholds derived from noise and drift.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Thresholds {
    /// Normal force at which contact begins, N.
    pub touch_on_n: f64,
    /// Normal force below which contact ends, N.
    pub touch_off_n: f64,
    /// Smallest element force used by the friction estimate, N.
    pub element_floor_n: f64,
    /// Standard deviation of the unloaded total force, N.
    pub noise_n: [f64; AXES],
    /// Drift of the total force, N per minute.
    pub drift_n_min: f64,
}

/// Estimates zero and noise from frames of equal width; `None` with too few.
#[must_use]
pub fn measure_silence(frames: &[Vec<f64>]) -> Option<Silence> {
    if frames.len() < FRAMES_MIN {
        return None;
    }
    let width = frames[0].len();
    let zero = (0..width).map(|value| mean(frames.iter().map(|frame| frame[value])));
    let noise = (0..width).map(|value| noise_std(frames.iter().map(|frame| frame[value])));
    Some(Silence {
        zero: zero.collect(),
        noise: noise.collect(),
    })
}

impl Thresholds {
    /// Derives thresholds from the unloaded recording. Contact begins at `multiple` standard
    /// deviations and ends at half of that. Both include one minute of drift, because a zero is
    /// usually older.
    #[must_use]
    pub fn from_recording(
        calibration: &Calibration,
        frames: &[Vec<f64>],
        seconds: f64,
        multiple: f64,
    ) -> Option<Self> {
        if frames.len() < FRAMES_MIN || seconds <= 0.0 {
            return None;
        }
        let elements = 0..calibration.elements_out();
        let totals: Vec<[f64; AXES]> = frames
            .iter()
            .map(|frame| {
                elements.clone().fold([0.0; AXES], |sum, element| {
                    let force_n = calibration.force_n(element, frame);
                    core::array::from_fn(|axis| sum[axis] + force_n[axis])
                })
            })
            .collect();
        let noise_n: [f64; AXES] =
            core::array::from_fn(|axis| noise_std(totals.iter().map(|total| total[axis])));
        let tenth = (totals.len() / 10).max(1);
        // Differences within noise are not drift.
        let chance = SIGNIFICANT_SIGMAS * (2.0 / tenth as f64).sqrt();
        let ends = |axis: usize| {
            let end = |of: &[[f64; AXES]]| mean(of.iter().map(|total| total[axis]));
            let moved_n = end(&totals[totals.len() - tenth..]) - end(&totals[..tenth]);
            (moved_n.abs() - chance * noise_n[axis]).max(0.0)
        };
        let drift_n_min = (0..AXES).map(ends).fold(0.0, f64::max) * 60.0 / seconds;
        let element_noise_n = elements.map(|element| {
            noise_std(
                frames
                    .iter()
                    .map(|frame| calibration.force_n(element, frame)[0]),
            )
        });
        Some(Self {
            touch_on_n: multiple * noise_n[0] + drift_n_min,
            touch_off_n: 0.5 * multiple * noise_n[0] + drift_n_min,
            element_floor_n: 0.5 * multiple * element_noise_n.fold(0.0, f64::max),
            noise_n,
            drift_n_min,
        })
    }
}

pub(super) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// Returns the standard deviation around a running mean of 32 frames.
pub(super) fn noise_std(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    let around = |index: usize| {
        let from = index.saturating_sub(16);
        let to = (index + 16).min(values.len());
        mean(values[from..to].iter().copied())
    };
    let squares = (0..values.len()).map(|index| (values[index] - around(index)).powi(2));
    // The running mean removes 1/32 of the variance.
    (mean(squares) * 32.0 / 31.0).sqrt()
}
