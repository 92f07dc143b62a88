//! Sensor of one fingertip: readings of all elements from the forces on them.

use nalgebra::{Matrix3, Vector3};
use shm_schemas::Layout;
use shm_schemas::capacity::ELEMENTS;

use super::skin::Skin;
use super::wear::{Dead, Drift, Wear};
use crate::random::Random;
use crate::scene::{Errors, stream};
use crate::sensor_model::SensorModel;

pub(super) const AXES: usize = 3;

/// One value per element and axis, element by element.
type PerAxis = [f64; AXES * ELEMENTS];

#[derive(Clone, Debug)]
pub(crate) struct TipSensor {
    /// One per element, as in the next two fields.
    gain: Vec<f64>,
    /// Crosstalk: readings over forces along the element's axes, without the gain.
    mixing: Vec<Matrix3<f64>>,
    bias_n: Vec<Vector3<f64>>,
    noise_factor: f64,
    noise_ratio: f64,
    /// Variance of the additive noise, N².
    noise_n2: PerAxis,
    step_n: PerAxis,
    /// Largest magnitude of a reading per axis, N; a multiple of the step.
    saturation_n: Option<[f32; AXES]>,
    random: Random,
    skin: Option<Skin>,
    wear: Option<Wear>,
    drift: Option<Drift>,
    dead: Option<Dead>,
    period_s: f64,
    /// Number of samples so far.
    samples: u64,
}

impl TipSensor {
    /// Draws the gains, and then the noise of every sample, from `random`.
    pub(super) fn new(
        elements: usize,
        model: &SensorModel,
        period_s: f64,
        noise_factor: f64,
        mut random: Random,
    ) -> Self {
        let gain = (0..elements)
            .map(|_| 1.0 + model.gain_spread * random.gaussian())
            .collect();
        let axes = |[normal, shear]: [f64; 2]| [normal, shear, shear];
        let per_axis = |pair| core::array::from_fn(|index| axes(pair)[index % AXES]);
        let step_n = axes(model.step_n);
        let saturation_n = model.saturation_n.map(|limit_n| {
            let limit_n = axes(limit_n);
            core::array::from_fn(|axis| quantised(limit_n[axis], step_n[axis]) as f32)
        });
        Self {
            gain,
            mixing: vec![Matrix3::identity(); elements],
            bias_n: vec![Vector3::zeros(); elements],
            noise_factor,
            noise_ratio: model.noise_ratio,
            noise_n2: per_axis(model.noise_n.map(|noise_n| noise_n * noise_n)),
            step_n: per_axis(model.step_n),
            saturation_n,
            random,
            skin: Skin::new(model, elements, period_s),
            wear: Wear::new(model, elements),
            drift: Drift::new(model, elements),
            dead: None,
            period_s,
            samples: 0,
        }
    }

    /// Draws crosstalk and offset of every element and a common gain.
    pub(super) fn apply_errors(&mut self, errors: &Errors, random: &mut Random) {
        let gain = 1.0 + errors.gain * random.between(-1.0, 1.0);
        for element in 0..self.gain.len() {
            let mut draw = |half_width: f64| half_width * random.between(-1.0, 1.0);
            let mixed = Matrix3::from_fn(|_, _| draw(errors.crosstalk));
            self.mixing[element] += mixed - Matrix3::from_diagonal(&mixed.diagonal());
            self.bias_n[element] += Vector3::from_fn(|_, _| draw(errors.bias_n));
            self.gain[element] *= gain;
        }
    }

    /// Draws crosstalk, offsets and dead elements of a model, each from its own stream of the seed.
    pub(super) fn draw_model(&mut self, model: &SensorModel, seed: u64, tip: u64) {
        if model.crosstalk > 0.0 || model.bias_n > 0.0 {
            let of_model = Errors {
                crosstalk: model.crosstalk,
                bias_n: model.bias_n,
                ..Errors::NONE
            };
            self.apply_errors(&of_model, &mut Random::new(seed, stream::MODEL_AXES + tip));
        }
        let mut random = Random::new(seed, stream::DEAD_ELEMENTS + tip);
        self.dead = Dead::new(model, self.gain.len(), &mut random);
    }

    /// Returns the fingertip with another noise stream.
    pub(super) fn on_bench(&self) -> Self {
        let mut tip = self.clone();
        tip.random = Random::new(tip.random.bits(), stream::BENCH);
        tip
    }

    /// Converts forces on the elements, tip frame, to readings along their axes.
    pub(crate) fn sample(
        &mut self,
        layout: &Layout,
        force_n: &[Vector3<f64>],
        reading_n: &mut [[f32; 3]],
    ) {
        let mut draws = [0.0; AXES * ELEMENTS];
        let draws = &mut draws[..AXES * force_n.len()];
        self.random.fill_gaussian(draws);
        let time_s = self.samples as f64 * self.period_s;
        self.samples += 1;
        // Two loops: the second one, with roots and divisions, vectorises over all axes.
        let (mut truth_n, mut felt_n) = ([[0.0; AXES]; ELEMENTS], [[0.0; AXES]; ELEMENTS]);
        for (element, force) in force_n.iter().enumerate() {
            let along = |axis: &[f64; 3]| force.x * axis[0] + force.y * axis[1] + force.z * axis[2];
            let mut axes_n = Vector3::new(
                -along(&layout.normal[element]),
                along(&layout.tangent1[element]),
                along(&layout.tangent2[element]),
            );
            if let Some(skin) = &mut self.skin {
                axes_n = skin.advance(element, axes_n);
            }
            let mut truth = self.mixing[element] * axes_n;
            if let Some(wear) = &mut self.wear {
                truth *= wear.remaining_gain(element, axes_n.x, self.period_s);
            }
            truth_n[element] = truth.into();
            felt_n[element] = (truth * self.gain[element] + self.bias_n[element]).into();
        }
        if let Some(drift) = &self.drift {
            let drift_n = drift.element_n(time_s);
            for felt_n in felt_n.iter_mut().take(force_n.len()) {
                for (felt_n, drift_n) in felt_n.iter_mut().zip(drift_n) {
                    *felt_n += drift_n;
                }
            }
        }
        self.read(&truth_n, &felt_n, draws, reading_n);
        self.limit(time_s, &mut reading_n[..force_n.len()]);
    }

    /// Adds noise and rounds to steps.
    fn read(
        &self,
        truth_n: &[[f64; AXES]; ELEMENTS],
        felt_n: &[[f64; AXES]; ELEMENTS],
        draws: &[f64],
        reading_n: &mut [[f32; AXES]],
    ) {
        let (truth_n, felt_n) = (truth_n.as_flattened(), felt_n.as_flattened());
        let readings = reading_n.as_flattened_mut().iter_mut();
        let forces = truth_n.iter().zip(felt_n);
        let axes = self.noise_n2.iter().zip(&self.step_n);
        for (((reading, draw), (truth_n, felt_n)), (noise_n2, step_n)) in
            readings.zip(draws).zip(forces).zip(axes)
        {
            let proportional_n = self.noise_ratio * truth_n;
            let noise_n = self.noise_factor * (noise_n2 + proportional_n * proportional_n).sqrt();
            *reading = quantised(felt_n + noise_n * draw, *step_n) as f32;
        }
    }

    /// Applies saturation and dead elements.
    fn limit(&mut self, time_s: f64, reading_n: &mut [[f32; AXES]]) {
        if let Some(limit_n) = self.saturation_n {
            for (reading_n, limit_n) in reading_n
                .as_flattened_mut()
                .iter_mut()
                .zip(limit_n.iter().cycle())
            {
                *reading_n = reading_n.clamp(-limit_n, *limit_n);
            }
        }
        if let Some(dead) = &mut self.dead {
            dead.apply(time_s, reading_n);
        }
    }
}

/// Rounds to the nearest multiple of a step, ties to even. Adding and subtracting 1.5·2⁵² rounds
/// without a library call; exact for magnitudes below 2⁵¹ steps.
#[inline]
pub(crate) fn quantised(value: f64, step: f64) -> f64 {
    const ROUNDER: f64 = 6_755_399_441_055_744.0;
    ((value / step + ROUNDER) - ROUNDER) * step
}

#[cfg(test)]
mod tests;
