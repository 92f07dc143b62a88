//! From true element forces and joint angles to what the robot gets to see.
//!
//! Fingertip elements: a gain of their own, additive and proportional Gaussian noise, a step of 1 mN, and a rate that may
//! be slower than the tick. Encoders: steps, no noise.

use nalgebra::Vector3;
use robot_model::{ARM_JOINTS, HAND_JOINTS};
use shm_schemas::layout::Layout;

use crate::pad::DOME_ELEMENTS;
use crate::random::Random;

/// Additive noise per element and axis, N, standard deviation (tactile design).
const NOISE_N: f64 = 0.003;
/// Proportional noise, standard deviation over reading (tactile design).
const NOISE_RATIO: f64 = 0.01;
/// Spread of the elements' gains, standard deviation (tactile design).
const GAIN_SPREAD: f64 = 0.03;
/// Step of a reading, N (tactile design).
const STEP_N: f64 = 0.001;

/// Step of an arm joint's encoder, rad: 20 bits per turn. At the 0.5 m reach of the arm 3 µm at the tip.
const ARM_ENCODER_STEP_RAD: f64 = core::f64::consts::TAU / (1 << 20) as f64;
/// Step of a finger joint's encoder, rad: 18 bits per turn. At the 90 mm from knuckle to tip 2.2 µm, the position quantum
/// of the tactile design.
const FINGER_ENCODER_STEP_RAD: f64 = core::f64::consts::TAU / (1 << 18) as f64;
/// Step of a measured joint velocity, rad/s. Ours: the resolution of a drive's own observer.
const VELOCITY_STEP_RAD_S: f64 = 1e-3;
/// Step of a measured joint torque, N·m. Ours.
const EFFORT_STEP_N_M: f64 = 1e-3;

/// Draws per element: three axes.
const DRAWS: usize = 3 * DOME_ELEMENTS;

/// One fingertip's electronics.
#[derive(Clone, Debug)]
pub(crate) struct TipSensor {
    gain: [f64; DOME_ELEMENTS],
    noise_factor: f64,
    random: Random,
}

impl TipSensor {
    /// A sensor with its own gains and noise; `noise_factor` scales the noise, not the gains.
    pub(crate) fn new(noise_factor: f64, mut random: Random) -> Self {
        let gain = core::array::from_fn(|_| 1.0 + GAIN_SPREAD * random.gaussian());
        Self {
            gain,
            noise_factor,
            random,
        }
    }

    /// One sample: true forces of the object on the elements, tip frame, become readings along the elements' axes.
    pub(crate) fn sample(
        &mut self,
        layout: &Layout,
        force_n: &[Vector3<f64>; DOME_ELEMENTS],
        reading_n: &mut [[f32; 3]],
    ) {
        let mut draws = [0.0; DRAWS];
        self.random.fill_gaussian(&mut draws);
        for (element, reading) in reading_n.iter_mut().enumerate().take(DOME_ELEMENTS) {
            let force = &force_n[element];
            let along = |axis: &[f64; 3]| force.x * axis[0] + force.y * axis[1] + force.z * axis[2];
            let truth = [
                -along(&layout.normal[element]),
                along(&layout.tangent1[element]),
                along(&layout.tangent2[element]),
            ];
            for axis in 0..3 {
                let noise_n = self.noise_n(truth[axis]) * draws[3 * element + axis];
                reading[axis] =
                    quantised(truth[axis] * self.gain[element] + noise_n, STEP_N) as f32;
            }
        }
    }

    /// Standard deviation of a reading, N.
    fn noise_n(&self, truth_n: f64) -> f64 {
        let proportional_n = NOISE_RATIO * truth_n;
        self.noise_factor * (NOISE_N * NOISE_N + proportional_n * proportional_n).sqrt()
    }
}

/// What the encoders of one joint of a hand make of its position, rad.
pub(crate) fn encoder_rad(joint: usize, position_rad: f64) -> f64 {
    debug_assert!(joint < HAND_JOINTS);
    quantised(
        position_rad,
        if joint < ARM_JOINTS {
            ARM_ENCODER_STEP_RAD
        } else {
            FINGER_ENCODER_STEP_RAD
        },
    )
}

/// What a drive reports as velocity, rad/s.
pub(crate) fn measured_velocity_rad_s(velocity_rad_s: f64) -> f64 {
    quantised(velocity_rad_s, VELOCITY_STEP_RAD_S)
}

/// What a drive reports as torque, N·m.
pub(crate) fn measured_effort_n_m(effort_n_m: f64) -> f64 {
    quantised(effort_n_m, EFFORT_STEP_N_M)
}

/// The nearest multiple of a step, ties to even. Adding and subtracting 1.5·2⁵² rounds without a library call; exact for
/// magnitudes below 2⁵¹ steps.
#[inline]
fn quantised(value: f64, step: f64) -> f64 {
    const ROUNDER: f64 = 6_755_399_441_055_744.0;
    ((value / step + ROUNDER) - ROUNDER) * step
}
