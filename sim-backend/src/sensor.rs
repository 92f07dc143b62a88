//! Tactile sensor of one hand: converts true element forces to sealed frames.
//!
//! Every element has its own gain, additive and proportional Gaussian noise, and a resolution of 1
//! mN. [`Errors`] add crosstalk and offsets. A sensor may sample more slowly than the tick; ticks
//! without a sample have no frame.

use nalgebra::{Matrix3, Vector3};
use robot_model::HandSide;
use shm_schemas::capacity::ELEMENTS;
use shm_schemas::{Hand, HandFrame, Layout};

use crate::clock::Clock;
use crate::contact::Contact;
use crate::pad::Pad;
use crate::random::Random;
use crate::scene::{Errors, stream};

/// Additive noise per element and axis, N, standard deviation (tactile design).
const NOISE_N: f64 = 0.003;
/// Proportional noise, standard deviation over the reading (tactile design).
const NOISE_RATIO: f64 = 0.01;
/// Standard deviation of the element gains (tactile design).
const GAIN_SPREAD: f64 = 0.03;
/// Resolution of a reading, N (tactile design).
const STEP_N: f64 = 0.001;
const AXES: usize = 3;

#[derive(Clone, Debug)]
pub(crate) struct HandSensor {
    hand: Hand,
    layout: Layout,
    layout_hash: u64,
    tips: Vec<TipSensor>,
    rate_hz: u64,
    sequence: u64,
}

#[derive(Clone, Debug)]
pub(crate) struct TipSensor {
    /// One per element, as in the next two fields.
    gain: Vec<f64>,
    /// Crosstalk: readings over forces along the element's axes, without the gain.
    mixing: Vec<Matrix3<f64>>,
    bias_n: Vec<Vector3<f64>>,
    noise_factor: f64,
    random: Random,
}

impl HandSensor {
    /// Each fingertip draws gains and noise from its stream in `random`, [`Errors`] from the
    /// streams of `errors`. `noise_factor` scales the noise only.
    pub(crate) fn new(
        side: HandSide,
        layout: Layout,
        rate_hz: u32,
        noise_factor: f64,
        random: Vec<Random>,
        errors: (&Errors, Vec<Random>),
    ) -> Self {
        let tips = random.into_iter();
        let mut tips: Vec<_> = tips
            .map(|random| TipSensor::new(layout.count, noise_factor, random))
            .collect();
        let (errors, mut draws) = errors;
        for (tip, random) in tips.iter_mut().zip(&mut draws) {
            tip.apply_errors(errors, random);
        }
        Self {
            hand: Hand::BOTH[side.index()],
            layout_hash: layout.hash(),
            layout,
            tips,
            rate_hz: rate_hz.into(),
            sequence: 0,
        }
    }

    /// Samples this tick's frame; `None` if no sample is due or no fingertip exists.
    pub(crate) fn sample(
        &mut self,
        clock: &Clock,
        pads: &[Pad],
        contacts: &[Contact],
        out: &mut Option<HandFrame>,
    ) {
        if self.tips.is_empty() || !self.is_due(clock.tick) {
            *out = None;
            return;
        }
        let frame = out.insert(HandFrame::default());
        frame.stamp = clock.stamp(self.sequence);
        self.sequence += 1;
        frame.layout_hash = self.layout_hash;
        frame.hand = self.hand;
        frame.finger_count = self.tips.len() as u32;
        let count = self.layout.count;
        let mut force_n = [Vector3::zeros(); ELEMENTS];
        let force_n = &mut force_n[..count];
        for (finger, (tip, contact)) in self.tips.iter_mut().zip(contacts).enumerate() {
            frame.valid_mask[finger] = u64::MAX >> (ELEMENTS - count);
            contact.element_forces(&pads[finger], force_n);
            tip.sample(&self.layout, force_n, &mut frame.force_n[finger]);
        }
        frame.seal();
    }

    /// Returns a fingertip's electronics with another noise stream.
    pub(crate) fn tip(&self, finger: usize) -> Option<TipSensor> {
        let mut tip = self.tips.get(finger)?.clone();
        tip.random = Random::new(tip.random.bits(), stream::BENCH);
        Some(tip)
    }

    /// Returns whether the sample count rises in this tick.
    fn is_due(&self, tick: u64) -> bool {
        let samples = |ticks: u64| ticks * self.rate_hz / 1000;
        tick == 0 || samples(tick) != samples(tick - 1)
    }
}

impl TipSensor {
    fn new(elements: usize, noise_factor: f64, mut random: Random) -> Self {
        let gain = (0..elements)
            .map(|_| 1.0 + GAIN_SPREAD * random.gaussian())
            .collect();
        Self {
            gain,
            mixing: vec![Matrix3::identity(); elements],
            bias_n: vec![Vector3::zeros(); elements],
            noise_factor,
            random,
        }
    }

    /// Draws crosstalk and offset of every element and a common gain.
    fn apply_errors(&mut self, errors: &Errors, random: &mut Random) {
        let gain = 1.0 + errors.gain * random.between(-1.0, 1.0);
        for element in 0..self.gain.len() {
            let mut draw = |half_width: f64| half_width * random.between(-1.0, 1.0);
            let mixed = Matrix3::from_fn(|_, _| draw(errors.crosstalk));
            self.mixing[element] += mixed - Matrix3::from_diagonal(&mixed.diagonal());
            self.bias_n[element] = Vector3::from_fn(|_, _| draw(errors.bias_n));
            self.gain[element] *= gain;
        }
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
        // Two loops: the second one, with roots and divisions, vectorises over all axes.
        let (mut truth_n, mut felt_n) = ([[0.0; AXES]; ELEMENTS], [[0.0; AXES]; ELEMENTS]);
        for (element, force) in force_n.iter().enumerate() {
            let along = |axis: &[f64; 3]| force.x * axis[0] + force.y * axis[1] + force.z * axis[2];
            let truth = self.mixing[element]
                * Vector3::new(
                    -along(&layout.normal[element]),
                    along(&layout.tangent1[element]),
                    along(&layout.tangent2[element]),
                );
            truth_n[element] = truth.into();
            felt_n[element] = (truth * self.gain[element] + self.bias_n[element]).into();
        }
        let (truth_n, felt_n) = (truth_n.as_flattened(), felt_n.as_flattened());
        let readings = reading_n.as_flattened_mut().iter_mut();
        for (((reading, draw), truth_n), felt_n) in readings.zip(&*draws).zip(truth_n).zip(felt_n) {
            *reading = quantised(felt_n + self.noise_n(*truth_n) * draw, STEP_N) as f32;
        }
    }

    fn noise_n(&self, truth_n: f64) -> f64 {
        let proportional_n = NOISE_RATIO * truth_n;
        self.noise_factor * (NOISE_N * NOISE_N + proportional_n * proportional_n).sqrt()
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
mod tests {
    use super::*;

    #[test]
    fn readings_are_quantised() {
        let check = |value: f64, step: f64, expected: f64| {
            assert!(
                (quantised(value, step) - expected).abs() < 1e-12,
                "{value} in steps of {step}"
            );
        };
        check(0.0014, 0.001, 0.001);
        check(-0.0016, 0.001, -0.002);
        check(0.0, 0.001, 0.0);
        check(8.123_456, 0.001, 8.123);
        check(2.5, 1.0, 2.0);
        check(-1e9, 0.5, -1e9);
    }

    /// A normal force read on a tangential axis is crosstalk; a reading without force is bias.
    #[test]
    fn sensor_errors_add_crosstalk_and_bias() {
        let errors = Errors {
            crosstalk: 0.05,
            bias_n: 0.02,
            ..Errors::NONE
        };
        let layout = Layout::dome_41();
        let mut tip = TipSensor::new(layout.count, 0.0, Random::new(1, 2));
        tip.apply_errors(&errors, &mut Random::new(1, 3));
        let mut read = |normal_n: f64| {
            let force_n: [Vector3<f64>; ELEMENTS] =
                core::array::from_fn(|e| -Vector3::from(layout.normal[e]) * normal_n);
            let mut reading_n = [[0.0_f32; AXES]; ELEMENTS];
            tip.sample(&layout, &force_n[..layout.count], &mut reading_n);
            reading_n
        };
        let (silent_n, pressed_n) = (read(0.0), read(1.0));
        let (mut farthest, mut mean) = (0.0_f64, 0.0);
        for (silent_n, pressed_n) in silent_n.iter().zip(&pressed_n).take(layout.count) {
            assert!(silent_n.iter().all(|bias_n| bias_n.abs() < 0.0206));
            let mixed = f64::from(pressed_n[1] - silent_n[1]);
            farthest = farthest.max(mixed.abs());
            mean += mixed / layout.count as f64;
        }
        assert!(farthest > 0.03 && farthest < 0.056, "{farthest}");
        assert!(mean.abs() < 0.015, "{mean}");
    }

    /// Constant force on one element: the mean of many samples shows the gain, the spread the
    /// noise.
    #[test]
    fn noise_grows_with_the_force() {
        let layout = Layout::dome_41();
        for (normal_n, expected_n) in [(0.0, 0.003), (0.3, 0.004_243), (2.0, 0.020_224)] {
            let mut tip = TipSensor::new(layout.count, 1.0, Random::new(1, 2));
            let mut force_n = vec![Vector3::zeros(); layout.count];
            force_n[5] = -Vector3::from(layout.normal[5]) * normal_n;
            let mut reading_n = [[0.0_f32; AXES]; ELEMENTS];
            let readings: Vec<f64> = (0..20_000)
                .map(|_| {
                    tip.sample(&layout, &force_n, &mut reading_n);
                    f64::from(reading_n[5][0])
                })
                .collect();
            let mean_n = readings.iter().sum::<f64>() / 20_000.0;
            let square_n2 = readings
                .iter()
                .map(|r| (r - mean_n) * (r - mean_n))
                .sum::<f64>()
                / 20_000.0;
            assert!(
                (mean_n - tip.gain[5] * normal_n).abs() < 5e-4,
                "{mean_n} N for {normal_n} N"
            );
            assert!(
                (square_n2.sqrt() / expected_n - 1.0).abs() < 0.03,
                "{} N at {normal_n} N",
                square_n2.sqrt()
            );
        }
    }
}
