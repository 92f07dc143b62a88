//! Perception of one fingertip: filter, contact, tangential increment, friction.

use super::friction::Friction;
use super::increment::Increment;
use super::motion::{Motion, MotionPercept};
use super::noise::Noise;
use super::patch::{ElementAxes, Patch};
use crate::intake::ValidatedFrame;
use crate::limits::{FRICTION_FLOOR, MASKED_DECAY_S};
use crate::settings::{Perception, Settings};
use nalgebra::Vector3;
use shm_schemas::Layout;
use shm_schemas::capacity::ELEMENTS;

/// Standard deviations of the unloaded force that are no contact (design choice: one false contact
/// in about a million frames).
const NOISE_MARGIN: f64 = 5.0;

/// Tactile state of one fingertip or grasp side.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ContactPercept {
    /// Filtered force of the object on the fingertip, tip frame, N.
    pub force_tip_n: Vector3<f64>,
    /// Torque of the object on the fingertip about the origin of the tip frame, tip frame, N·m.
    pub torque_tip_n_m: Vector3<f64>,
    /// Outward normal of the contact patch, unit vector, tip frame.
    pub patch_normal: Vector3<f64>,
    /// F_n: force along the inward patch normal, N, positive when pressed.
    pub normal_n: f64,
    /// F_t: magnitude of the force in the patch plane, N.
    pub tangential_n: f64,
    /// dF_t: magnitude of the tangential force change over the window, N.
    pub increment_n: f64,
    /// S: F_t/F_n relative to the remembered friction; 1 means gross slip.
    pub utilisation: f64,
    /// S relative to the present friction reading.
    pub utilisation_now: f64,
    /// μ̂: largest friction coefficient since first touch; 0 while unknown.
    pub friction: f64,
    /// The face shows incipient slip. Otherwise S is 0 until a slip is observed.
    pub shows_incipient_slip: bool,
    /// Standard deviation of a few-element friction reading due to noise.
    pub friction_error: f64,
    /// Scatter of the shear direction between elements, standard deviation over their normal force:
    /// crosstalk.
    pub scatter: f64,
    /// Loaded share of the face, above 0; 1 for curved faces, whose compression includes the growth
    /// of the contact.
    pub loaded_share: f64,
    /// Effective number of loaded fingertips; 1 for a fingertip.
    pub loaded_fingertips: f64,
    /// Moment of the shear about the outward normal of the patch, N·m.
    pub moment_n_m: f64,
    /// Torsion ratio: moment about the patch normal relative to its friction limit.
    pub torsion: f64,
    /// Duration of gross slip, s.
    pub gross_slip_s: f64,
    /// The fingertip is in contact, with hysteresis.
    pub in_contact: bool,
    /// Number of contacts since the start.
    pub touches: u64,
    /// Persistence of changes in the readings.
    pub motion: MotionPercept,
}

impl Default for ContactPercept {
    fn default() -> Self {
        Self {
            force_tip_n: Vector3::zeros(),
            torque_tip_n_m: Vector3::zeros(),
            patch_normal: Vector3::z(),
            normal_n: 0.0,
            tangential_n: 0.0,
            increment_n: 0.0,
            utilisation: 0.0,
            utilisation_now: 0.0,
            friction: 0.0,
            shows_incipient_slip: true,
            friction_error: 0.0,
            scatter: 0.0,
            loaded_share: 1.0,
            loaded_fingertips: 1.0,
            moment_n_m: 0.0,
            torsion: 0.0,
            gross_slip_s: 0.0,
            in_contact: false,
            touches: 0,
            motion: MotionPercept::default(),
        }
    }
}

/// State of one fingertip.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FingertipPerception {
    axes: ElementAxes,
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    filtered_n: [[f64; 3]; ELEMENTS],
    /// Readings after the friction filter.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    slow_n: [[f64; 3]; ELEMENTS],
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    bias_n: [[f64; 3]; ELEMENTS],
    noise: Noise,
    increment: Increment,
    friction: Friction,
    motion: Motion,
    /// The filters have a reading. They start from it: a hand may already hold an object.
    has_started: bool,
    percept: ContactPercept,
}

impl FingertipPerception {
    /// Creates an unloaded fingertip with this layout.
    #[must_use]
    pub fn new(layout: &Layout) -> Self {
        Self {
            axes: ElementAxes::new(layout),
            filtered_n: [[0.0; 3]; ELEMENTS],
            slow_n: [[0.0; 3]; ELEMENTS],
            bias_n: [[0.0; 3]; ELEMENTS],
            noise: Noise::default(),
            increment: Increment::default(),
            friction: Friction::default(),
            motion: Motion::default(),
            has_started: false,
            percept: ContactPercept::default(),
        }
    }

    /// Adds one frame.
    pub fn update(
        &mut self,
        finger: usize,
        frame: &ValidatedFrame<'_>,
        slips: bool,
        all: &Settings,
    ) -> ContactPercept {
        let settings = &all.perception;
        let share = self.filter(finger, frame, settings);
        let patch = Patch::new(
            &self.axes,
            &self.filtered_n,
            self.noise.variance_n2(),
            settings.element_floor_n,
        );
        self.update_contact(&patch, settings);
        if self.percept.in_contact {
            self.noise.pause();
        } else {
            let (elements_n, count) = (&self.filtered_n, self.axes.count);
            self.noise.update(elements_n, count, share, frame.step_s());
        }
        let steady_noise_n2 = self.filter_slow(share, frame.step_s(), settings);
        let (axes, steady_n) = (&self.axes, &self.slow_n);
        let steady = || Patch::new(axes, steady_n, steady_noise_n2, settings.element_floor_n);
        let slipping = self.friction.update(
            &patch,
            self.axes.is_round,
            steady,
            slips,
            frame.step_s(),
            all,
        );
        self.percept = ContactPercept {
            force_tip_n: patch.force_n,
            torque_tip_n_m: patch.torque_n_m,
            patch_normal: patch.normal,
            normal_n: patch.normal_n,
            tangential_n: patch.tangential_n.norm(),
            increment_n: self.increment.update(
                &patch.tangential_n,
                frame,
                settings.increment_window_s,
            ),
            utilisation: slipping.utilisation,
            utilisation_now: slipping.utilisation_now,
            friction: slipping.friction,
            shows_incipient_slip: self.axes.is_round,
            friction_error: slipping.error,
            scatter: patch.scatter,
            loaded_fingertips: 1.0,
            loaded_share: self
                .axes
                .loaded_share(&self.filtered_n, self.noise.variance_n2()),
            moment_n_m: patch.moment_n_m,
            torsion: torsion(&patch, slipping.friction),
            gross_slip_s: slipping.gross_s,
            in_contact: self.percept.in_contact,
            touches: self.percept.touches,
            motion: self.motion.update(finger, self.axes.count, frame, settings),
        };
        self.percept
    }

    /// Zeroes the filtered readings of all elements.
    pub fn bias(&mut self) {
        for (bias, filtered) in self.bias_n.iter_mut().zip(&mut self.filtered_n) {
            for axis in 0..3 {
                bias[axis] += filtered[axis];
                filtered[axis] = 0.0;
            }
        }
        self.slow_n = [[0.0; 3]; ELEMENTS];
        self.noise.pause();
    }

    /// Low-passes every element. A masked element decays; it is zero while the valid ones feel no
    /// contact. Returns the filter gain.
    fn filter(&mut self, finger: usize, frame: &ValidatedFrame<'_>, settings: &Perception) -> f64 {
        let step_s = frame.step_s();
        let share = if settings.filter_s > 0.0 && self.has_started {
            step_s / (settings.filter_s + step_s)
        } else {
            1.0
        };
        let mut valid_n = 0.0;
        for element in 0..self.axes.count {
            let Some(force_n) = frame.element_n(finger, element) else {
                continue;
            };
            let axes = self.filtered_n[element]
                .iter_mut()
                .zip(self.bias_n[element]);
            for ((filtered, bias), force) in axes.zip(force_n) {
                *filtered += (force - bias - *filtered) * share;
            }
            valid_n += self.filtered_n[element][0];
        }
        let (_, valid) = frame.readings_n(finger);
        if valid.count_ones() as usize == self.axes.count {
            return share;
        }
        let kept = if valid_n > settings.touch_off_n {
            MASKED_DECAY_S / (MASKED_DECAY_S + step_s)
        } else {
            0.0
        };
        for element in 0..self.axes.count {
            if frame.element_n(finger, element).is_none() {
                self.filtered_n[element] = self.filtered_n[element].map(|n| n * kept);
            }
        }
        share
    }

    /// Applies the friction filter. Returns the variance of the remaining noise, N². `share` is the
    /// gain of the first filter.
    fn filter_slow(&mut self, share: f64, step_s: f64, settings: &Perception) -> f64 {
        let slow = if core::mem::replace(&mut self.has_started, true) {
            step_s / (settings.friction_filter_s + step_s)
        } else {
            1.0
        };
        for (steady, filtered) in self.slow_n.iter_mut().zip(&self.filtered_n) {
            for (steady, filtered) in steady.iter_mut().zip(filtered) {
                *steady += (filtered - *steady) * slow;
            }
        }
        // Variance ratio of white noise after both filters to that after the first.
        let kept = (1.0 - share) * (1.0 - slow);
        let quieter = slow / (2.0 - slow) * (1.0 + kept) / (1.0 - kept);
        quieter * self.noise.variance_n2()
    }

    /// Updates the contact with hysteresis; a single threshold flickers on real data. Sensor noise
    /// raises the thresholds.
    fn update_contact(&mut self, patch: &Patch, settings: &Perception) {
        let noise_n = NOISE_MARGIN * patch.noise_n * libm::sqrt(self.axes.count as f64);
        let raise = (noise_n / settings.touch_on_n).max(1.0);
        let percept = &mut self.percept;
        if !percept.in_contact && patch.normal_n > settings.touch_on_n * raise {
            percept.in_contact = true;
            percept.touches += 1;
        } else if percept.in_contact && patch.normal_n < settings.touch_off_n * raise {
            percept.in_contact = false;
            self.friction = Friction::default();
        }
    }
}

/// Returns the moment about the patch normal relative to its friction limit.
fn torsion(patch: &Patch, friction: f64) -> f64 {
    let most_n_m = friction.max(FRICTION_FLOOR) * patch.arm_n_m;
    if friction > 0.0 && most_n_m > 0.0 {
        patch.moment_n_m.abs() / most_n_m
    } else {
        0.0
    }
}
