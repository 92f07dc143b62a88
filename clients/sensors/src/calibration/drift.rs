//! How silence moves: with time, and with the temperature where a recording has one.

use serde::{Deserialize, Serialize};

use super::silence::{FRAMES_MIN, SURE, flicker, mean};
use super::{AXES, Calibration};

/// Least change of temperature that tells anything, K. Ours: several steps of what sensors report.
pub const WARMING_MIN_K: f64 = 0.5;

/// A silent recording.
#[derive(Clone, Debug, Default)]
pub struct Quiet {
    /// Per frame its values, in the device's unit.
    pub frames: Vec<Vec<f64>>,
    /// Per frame its time, s.
    pub times_s: Vec<f64>,
    /// Per frame the sensor's temperature, °C; empty where there is none.
    pub temperatures_c: Vec<f64>,
}

/// How the zero moves. What noise alone may look like is taken away.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drift {
    /// How long silence lasted, s.
    pub watched_s: f64,
    /// How far the force on each element moves in a minute, N.
    pub element_n_min: Vec<f64>,
    /// What warmth does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub warmth: Option<Warmth>,
}

/// What a kelvin does to forces. Of a sensor that warms up while it drifts for other reasons, it holds both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Warmth {
    /// How far the temperature moved, K.
    pub span_k: f64,
    /// The total force along `f_n`, `f_t1`, `f_t2`, N per kelvin.
    pub total_n_k: [f64; AXES],
    /// The same of each element.
    pub element_n_k: Vec<[f64; AXES]>,
}

impl Drift {
    /// Of what a calibration makes of silence. `None` if it is too short to tell.
    #[must_use]
    pub fn of(calibration: &Calibration, quiet: &Quiet) -> Option<Self> {
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
            warmth: Warmth::of(&quiet.temperatures_c, &elements),
        })
    }

    /// The element that moves most, and how far in a minute, N.
    #[must_use]
    pub fn worst(&self) -> (usize, f64) {
        let worst = |a: (usize, f64), b: (usize, f64)| if b.1 > a.1 { b } else { a };
        let elements = self.element_n_min.iter().copied().enumerate();
        elements.fold((0, 0.0), worst)
    }

    /// Whether every number is one.
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

impl Warmth {
    fn of(temperatures_c: &[f64], elements: &[Vec<[f64; AXES]>]) -> Option<Self> {
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

    /// The greatest of the total force's axes, N per kelvin.
    #[must_use]
    pub fn total_most_n_k(&self) -> f64 {
        self.total_n_k
            .iter()
            .map(|n_k| n_k.abs())
            .fold(0.0, f64::max)
    }
}

/// Slopes of forces over something, N per unit of it, by least squares; nearer to 0 by what noise alone may make of them.
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
        let chance = SURE * flicker(along()) / spread.sqrt();
        slope.signum() * (slope.abs() - chance).max(0.0)
    })
}
