//! Perception of one fingertip: filter, contact, tangential increment, friction.

use super::friction::Friction;
use super::increment::Increment;
use super::lanes::{self, LANES, LANES_MASK, Lanes, Row, Rows};
use super::motion::{Motion, MotionPercept};
use super::noise::Noise;
use super::patch::{ElementAxes, LoadedElements, LoadedGroups, Patch};
use crate::intake::ValidatedFrame;
use crate::limits::{FRICTION_FLOOR, MASKED_DECAY_S, ZERO_TRACKING_S};
use crate::settings::{Perception, Settings};
use nalgebra::Vector3;
use shm_schemas::capacity::ELEMENTS;

/// Standard deviations of the unloaded force that are no contact (design choice: one false contact
/// in about a million frames).
const NOISE_MARGIN: f64 = 5.0;

/// Largest share of the force that failed elements count for (design choice: one element of a
/// contact that has grown; the loss of more cannot be told from drift).
const MASKED_SHARE_MAX: f64 = 0.25;

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
    /// Share of the normal force that elements carried before they became masked, 0 to a quarter;
    /// stays until no element is masked.
    pub masked_share: f64,
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
            masked_share: 0.0,
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
    filtered_n: Rows,
    /// Readings after the friction filter.
    slow_n: Rows,
    bias_n: Rows,
    /// Masked elements.
    masked: u64,
    noise: Noise,
    increment: Increment,
    friction: Friction,
    motion: Motion,
    /// The filters have a reading. They start from it: a hand may already hold an object.
    has_started: bool,
    percept: ContactPercept,
}

impl Default for FingertipPerception {
    /// Creates an unloaded fingertip.
    fn default() -> Self {
        Self {
            filtered_n: Rows::default(),
            slow_n: Rows::default(),
            bias_n: Rows::default(),
            masked: 0,
            noise: Noise::default(),
            increment: Increment::default(),
            friction: Friction::default(),
            motion: Motion::default(),
            has_started: false,
            percept: ContactPercept::default(),
        }
    }
}

impl FingertipPerception {
    /// Adds one frame.
    pub(super) fn update(
        &mut self,
        (finger, axes): (usize, &ElementAxes),
        frame: &ValidatedFrame<'_>,
        slips: bool,
        all: &Settings,
    ) -> &ContactPercept {
        let (settings, step_s) = (&all.perception, frame.step_s());
        let share = self.filter_share(step_s, settings);
        let change_n2 = self.filter((finger, axes), frame, share, settings);
        let floor_n = settings.element_floor_n;
        let patch = Patch::new(axes, &self.filtered_n, self.noise.variance_n2(), floor_n);
        self.update_contact(&patch, axes.count, settings);
        if self.percept.in_contact {
            self.noise.pause();
        } else {
            self.noise.update(change_n2, axes.count, share, step_s);
        }
        let slow_share = self.slow_share(step_s, settings);
        self.filter_slow(axes, slow_share);
        let (slow_n, steady_n2) = (&self.slow_n, self.steady_noise_n2(share, slow_share));
        let steady = || {
            let normal = axes.patch_normal(slow_n);
            let (mut groups, noise_n) = (LoadedGroups::new(), libm::sqrt(steady_n2));
            LoadedElements::new(&mut groups, (axes, slow_n), &normal, noise_n, floor_n)
                .most_loaded()
        };
        let slipping = self
            .friction
            .update(&patch, axes.is_round, steady, slips, step_s, all);
        let window_s = settings.increment_window_s;
        self.percept = ContactPercept {
            force_tip_n: patch.force_n,
            torque_tip_n_m: patch.torque_n_m,
            patch_normal: patch.normal,
            normal_n: patch.normal_n,
            tangential_n: patch.tangential_n.norm(),
            increment_n: self.increment.update(&patch.tangential_n, frame, window_s),
            utilisation: slipping.utilisation,
            utilisation_now: slipping.utilisation_now,
            friction: slipping.friction,
            shows_incipient_slip: axes.is_round,
            friction_error: slipping.error,
            scatter: patch.scatter,
            loaded_fingertips: 1.0,
            masked_share: self.percept.masked_share,
            loaded_share: axes.loaded_share(&self.filtered_n, self.noise.variance_n2()),
            moment_n_m: patch.moment_n_m,
            torsion: torsion(&patch, slipping.friction),
            gross_slip_s: slipping.gross_s,
            in_contact: self.percept.in_contact,
            touches: self.percept.touches,
            motion: self.motion.update(finger, axes.count, frame, settings),
        };
        &self.percept
    }

    /// Zeroes the filtered readings of all elements.
    pub(super) fn bias(&mut self) {
        for (bias, filtered) in self.bias_n.iter_mut().zip(&mut self.filtered_n) {
            *bias += *filtered;
            *filtered = Row::default();
        }
        self.slow_n = Rows::default();
        self.noise.pause();
    }

    /// Moves the zero of an untouched fingertip towards its readings, at a limited rate: a touch
    /// loads it faster than its sensor drifts.
    pub(super) fn track_zero(&mut self, count: usize, step_s: f64, settings: &Perception) {
        let [normals_n, ..] = &self.filtered_n;
        let share = step_s / (ZERO_TRACKING_S + step_s);
        let change_n = share * normals_n.sum(count).abs();
        let most_n = settings.zero_tracking_n_s * step_s;
        let limited = if change_n > most_n {
            most_n / change_n
        } else {
            1.0
        };
        let share = Lanes::splat(share * limited);
        for (bias_n, filtered_n) in self.bias_n.iter_mut().zip(&mut self.filtered_n) {
            for group in Row::groups(count) {
                let moved_n = filtered_n.group(group) * share;
                *bias_n.group_mut(group) += moved_n;
                *filtered_n.group_mut(group) -= moved_n;
            }
        }
    }

    /// Gain of the first filter.
    fn filter_share(&self, step_s: f64, settings: &Perception) -> f64 {
        if settings.filter_s > 0.0 && self.has_started {
            step_s / (settings.filter_s + step_s)
        } else {
            1.0
        }
    }

    /// Low-passes every element. A masked element decays; it is zero while the valid ones feel no
    /// contact. Returns the sum of the squared changes of the tangential readings, N².
    fn filter(
        &mut self,
        (finger, axes): (usize, &ElementAxes),
        frame: &ValidatedFrame<'_>,
        share: f64,
        settings: &Perception,
    ) -> f64 {
        let (readings_n, mask) = frame.readings_n(finger);
        let share = Lanes::splat(share);
        let mut changes_n2 = Lanes::ZERO;
        for group in Row::groups(axes.count) {
            let mut now_n = lanes::readings(readings_n, group);
            let before_n = lanes::group(&self.filtered_n, group);
            let bias_n = lanes::group(&self.bias_n, group);
            let valid = mask >> (LANES * group) & LANES_MASK;
            if valid != LANES_MASK {
                for axis in 0..3 {
                    // Masked readings and lanes without element keep their value.
                    lanes::replace(&mut now_n[axis], valid, bias_n[axis] + before_n[axis]);
                }
            }
            let change = |axis: usize| (now_n[axis] - bias_n[axis] - before_n[axis]) * share;
            let [normal_n, first_n, second_n] = [change(0), change(1), change(2)];
            changes_n2 += first_n * first_n + second_n * second_n;
            let [normals_n, firsts_n, seconds_n] = &mut self.filtered_n;
            *normals_n.group_mut(group) += normal_n;
            *firsts_n.group_mut(group) += first_n;
            *seconds_n.group_mut(group) += second_n;
        }
        self.update_masked_share(!mask & u64::MAX >> (ELEMENTS - axes.count), axes.count);
        if self.masked != 0 {
            let masked = (0..axes.count).filter(|element| mask >> element & 1 == 0);
            self.decay(masked, axes.count, frame.step_s(), settings);
        }
        lanes::sum(changes_n2)
    }

    /// Updates the share of elements that become masked. They still have their last valid force.
    fn update_masked_share(&mut self, masked: u64, count: usize) {
        let newly = masked & !self.masked;
        let before = core::mem::replace(&mut self.masked, masked);
        let [normals_n, ..] = &self.filtered_n;
        let share = &mut self.percept.masked_share;
        if masked == 0 {
            *share = 0.0;
        } else if newly != 0 {
            let sum_n = |set: u64| {
                let elements = (0..count).filter(|element| set >> element & 1 == 1);
                elements.map(|element| normals_n.get(element)).sum::<f64>()
            };
            let (newly_n, visible_n) = (sum_n(newly), sum_n(!before));
            if newly_n > 0.0 {
                let failed = newly_n / visible_n.max(newly_n);
                let sum = 1.0 - (1.0 - *share) * (1.0 - failed);
                *share = sum.min(MASKED_SHARE_MAX);
            }
        }
    }

    /// Decays the masked elements.
    fn decay(
        &mut self,
        masked: impl Iterator<Item = usize> + Clone,
        count: usize,
        step_s: f64,
        settings: &Perception,
    ) {
        let [normals_n, ..] = &self.filtered_n;
        let masked_n: f64 = masked.clone().map(|element| normals_n.get(element)).sum();
        let kept = if normals_n.sum(count) - masked_n > settings.touch_off_n {
            MASKED_DECAY_S / (MASKED_DECAY_S + step_s)
        } else {
            0.0
        };
        for element in masked {
            for row in &mut self.filtered_n {
                row.set(element, row.get(element) * kept);
            }
        }
    }

    /// Gain of the friction filter, which starts from the first reading.
    fn slow_share(&mut self, step_s: f64, settings: &Perception) -> f64 {
        if core::mem::replace(&mut self.has_started, true) {
            step_s / (settings.friction_filter_s + step_s)
        } else {
            1.0
        }
    }

    /// Applies the friction filter. Only round faces use its result.
    fn filter_slow(&mut self, axes: &ElementAxes, slow_share: f64) {
        if !axes.is_round {
            return;
        }
        let share = Lanes::splat(slow_share);
        for (slow_n, filtered_n) in self.slow_n.iter_mut().zip(&self.filtered_n) {
            for group in Row::groups(axes.count) {
                let change_n = filtered_n.group(group) - slow_n.group(group);
                *slow_n.group_mut(group) += change_n * share;
            }
        }
    }

    /// Variance of the noise that remains after both filters, of these gains, N².
    fn steady_noise_n2(&self, share: f64, slow_share: f64) -> f64 {
        // Variance ratio of white noise after both filters to that after the first.
        let kept = (1.0 - share) * (1.0 - slow_share);
        let quieter = slow_share / (2.0 - slow_share) * (1.0 + kept) / (1.0 - kept);
        quieter * self.noise.variance_n2()
    }

    /// Updates the contact with hysteresis; a single threshold flickers on real data. Sensor noise
    /// raises the thresholds.
    fn update_contact(&mut self, patch: &Patch, count: usize, settings: &Perception) {
        let noise_n = NOISE_MARGIN * patch.noise_n * libm::sqrt(count as f64);
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
