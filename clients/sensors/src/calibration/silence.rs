//! What a sensor says of silence: its zero, its noise, its drift, and the thresholds that follow.

use serde::Serialize;

use super::{AXES, Calibration};

/// Fewest frames that tell noise (ours: a standard deviation within 10 %).
pub(super) const FRAMES_MIN: usize = 50;

/// Standard deviations that are no chance (ours).
pub(super) const SURE: f64 = 3.0;

/// A sensor in silence, in its own unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Silence {
    /// Mean of every value.
    pub zero: Vec<f64>,
    /// Standard deviation of every value, without what changes slowly.
    pub noise: Vec<f64>,
}

/// Thresholds in multiples of the noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Thresholds {
    /// Normal force that counts as a touch, N.
    pub touch_on_n: f64,
    /// Normal force below which a touch has ended, N.
    pub touch_off_n: f64,
    /// Weakest element that takes part in the friction estimate, N.
    pub element_floor_n: f64,
    /// Standard deviation of the total force in silence, N.
    pub noise_n: [f64; AXES],
    /// How far the total force moved in a minute, N.
    pub drift_n_min: f64,
}

/// Listens to frames of one width. `None` if there are too few to tell.
#[must_use]
pub fn listen(frames: &[Vec<f64>]) -> Option<Silence> {
    if frames.len() < FRAMES_MIN {
        return None;
    }
    let width = frames[0].len();
    let zero = (0..width).map(|value| mean(frames.iter().map(|frame| frame[value])));
    let noise = (0..width).map(|value| flicker(frames.iter().map(|frame| frame[value])));
    Some(Silence {
        zero: zero.collect(),
        noise: noise.collect(),
    })
}

impl Thresholds {
    /// From the same silence in newtons: a touch begins `multiple` standard deviations above it, and ends at half of that. What
    /// drifts in a minute is added, since a zero is seldom younger.
    #[must_use]
    pub fn of(
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
            core::array::from_fn(|axis| flicker(totals.iter().map(|total| total[axis])));
        let tenth = (totals.len() / 10).max(1);
        // What both ends differ by chance is no drift.
        let chance = SURE * (2.0 / tenth as f64).sqrt();
        let ends = |axis: usize| {
            let end = |of: &[[f64; AXES]]| mean(of.iter().map(|total| total[axis]));
            let moved_n = end(&totals[totals.len() - tenth..]) - end(&totals[..tenth]);
            (moved_n.abs() - chance * noise_n[axis]).max(0.0)
        };
        let drift_n_min = (0..AXES).map(ends).fold(0.0, f64::max) * 60.0 / seconds;
        let element_noise_n = elements.map(|element| {
            flicker(
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

/// Standard deviation against a running mean of 32 frames: what changes slowly is drift.
pub(super) fn flicker(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    let around = |index: usize| {
        let from = index.saturating_sub(16);
        let to = (index + 16).min(values.len());
        mean(values[from..to].iter().copied())
    };
    let squares = (0..values.len()).map(|index| (values[index] - around(index)).powi(2));
    // A mean of 32 takes one part of 32 of the variance away.
    (mean(squares) * 32.0 / 31.0).sqrt()
}
