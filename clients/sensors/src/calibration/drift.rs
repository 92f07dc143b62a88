//! Drift of the unloaded sensor over time, and over temperature if recorded.

use serde::{Deserialize, Serialize};

use super::silence::{FRAMES_MIN, SIGNIFICANT_SIGMAS, mean, noise_std};
use super::{AXES, Calibration};

/// Smallest temperature change for a temperature estimate, K. Design choice: several steps of the
/// sensors' resolution.
pub const WARMING_MIN_K: f64 = 0.5;

/// Recording of an unloaded sensor.
#[derive(Clone, Debug, Default)]
pub struct UnloadedRecording {
    /// Values per frame, device units.
    pub frames: Vec<Vec<f64>>,
    /// Time per frame, s.
    pub times_s: Vec<f64>,
    /// Sensor temperature per frame, °C; empty if not recorded.
    pub temperatures_c: Vec<f64>,
}

/// Drift of the zero beyond the effect of noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drift {
    /// Duration of the recording, s.
    pub watched_s: f64,
    /// Drift of each element's force, N per minute.
    pub element_n_min: Vec<f64>,
    /// Temperature effect.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub warmth: Option<TemperatureEffect>,
}

/// Force change per kelvin; includes any other drift during warm-up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TemperatureEffect {
    /// Temperature range, K.
    pub span_k: f64,
    /// Total force along `f_n`, `f_t1`, `f_t2`, N per kelvin.
    pub total_n_k: [f64; AXES],
    /// Each element's force, N per kelvin.
    pub element_n_k: Vec<[f64; AXES]>,
}

impl Drift {
    /// Estimates the drift of a recording; `None` if it is too short.
    #[must_use]
    pub fn from_recording(calibration: &Calibration, quiet: &UnloadedRecording) -> Option<Self> {
        let watched_s = quiet.times_s.last()? - quiet.times_s.first()?;
        if quiet.frames.len() < FRAMES_MIN || watched_s <= 0.0 {
            return None;
        }
        let elements: Vec<Vec<[f64; AXES]>> = (0..calibration.elements_out())
            .map(|element| {
                let frames = quiet.frames.iter();
                frames
                    .map(|frame| calibration.force_n(element, frame))
                    .collect()
            })
            .collect();
        let in_a_minute = |forces_n: &Vec<[f64; AXES]>| {
            let [n, a, b] = slopes(&quiet.times_s, forces_n);
            60.0 * (n * n + a * a + b * b).sqrt()
        };
        Some(Self {
            watched_s,
            element_n_min: elements.iter().map(in_a_minute).collect(),
            warmth: TemperatureEffect::from_forces(&quiet.temperatures_c, &elements),
        })
    }

    /// Returns the element with the largest drift, N per minute.
    #[must_use]
    pub fn worst(&self) -> (usize, f64) {
        let worst = |a: (usize, f64), b: (usize, f64)| if b.1 > a.1 { b } else { a };
        let elements = self.element_n_min.iter().copied().enumerate();
        elements.fold((0, 0.0), worst)
    }

    pub(super) fn is_finite(&self) -> bool {
        let warmth = self.warmth.iter();
        let of_warmth =
            warmth.flat_map(|of| of.element_n_k.iter().chain([&of.total_n_k]).flatten());
        let mut numbers = self
            .element_n_min
            .iter()
            .chain([&self.watched_s])
            .chain(of_warmth);
        numbers.all(|number| number.is_finite())
    }
}

impl TemperatureEffect {
    fn from_forces(temperatures_c: &[f64], elements: &[Vec<[f64; AXES]>]) -> Option<Self> {
        let coldest = temperatures_c.iter().copied().fold(f64::INFINITY, f64::min);
        let warmest = temperatures_c
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        let span_k = warmest - coldest;
        if span_k.is_nan() || span_k < WARMING_MIN_K {
            return None;
        }
        let total: Vec<[f64; AXES]> = (0..temperatures_c.len())
            .map(|frame| {
                let sum = |axis: usize| elements.iter().map(|element| element[frame][axis]).sum();
                core::array::from_fn(sum)
            })
            .collect();
        let each = elements
            .iter()
            .map(|element| slopes(temperatures_c, element));
        Some(Self {
            span_k,
            total_n_k: slopes(temperatures_c, &total),
            element_n_k: each.collect(),
        })
    }

    /// Returns the largest component of `total_n_k`, N per kelvin.
    #[must_use]
    pub fn largest_total_n_k(&self) -> f64 {
        self.total_n_k
            .iter()
            .map(|n_k| n_k.abs())
            .fold(0.0, f64::max)
    }
}

/// Returns least-squares slopes of forces over `over`, reduced by the effect of noise.
fn slopes(over: &[f64], forces_n: &[[f64; AXES]]) -> [f64; AXES] {
    let middle = mean(over.iter().copied());
    let spread: f64 = over.iter().map(|at| (at - middle).powi(2)).sum();
    core::array::from_fn(|axis| {
        let along = || forces_n.iter().map(|force_n| force_n[axis]);
        let product: f64 = over
            .iter()
            .zip(along())
            .map(|(at, n)| (at - middle) * n)
            .sum();
        let slope = product / spread;
        let chance = SIGNIFICANT_SIGMAS * noise_std(along()) / spread.sqrt();
        slope.signum() * (slope.abs() - chance).max(0.0)
    })
}
