//! Perception: from believed frames to what each fingertip feels.
//!
//! In: [`CheckedFrame`]s of one hand, in order, each sensor frame exactly once (never a held sample twice: a tick-wise
//! difference of held samples spikes). Out: one [`Percept`] per tick. All windows and filters are in seconds of sensor
//! time, so a 30 Hz sensor and a 10 kHz tick mean the same.
//!
//! The contact-patch frame: the dome's own geometry would leak F_n·sin θ into the tangential force, so every element's
//! force is rotated into tip coordinates first and split along the patch normal.

mod finger;
mod friction;
mod increment;
mod motion;
mod noise;
mod object_pose;
mod patch;
mod stiffness;
mod virtual_finger;
mod yielding;

pub use finger::{Finger, FingerPercept};
pub use motion::MotionPercept;
pub use object_pose::ObjectPose;
pub use stiffness::{Bearing, StiffnessEstimate, StiffnessFit, compression};
pub use yielding::{YieldRule, YieldWatch, Yielded};

use crate::intake::CheckedFrame;
use crate::settings::Perception as Settings;
use crate::wiring::HandWiring;
use robot_model::{HandModel, VIRTUAL_FINGERS};
use shm_schemas::capacity::FINGERS;

/// What one hand feels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Percept {
    /// Per fingertip; those without a sensor feel nothing.
    pub fingers: [FingerPercept; FINGERS],
    /// The side from which each fingertip presses, 0 or 1.
    pub presses_from: [usize; FINGERS],
    /// Per side, what its fingertips feel together: what modules mean by a finger.
    pub virtual_fingers: [FingerPercept; VIRTUAL_FINGERS],
    /// Sensor time of the newest frame, ns.
    pub captured_ns: u64,
    /// Sensor time that the newest frames of this tick cover, s; 0 when none arrived.
    pub step_s: f64,
}

/// One hand's perception.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Perception {
    fingers: [Finger; FINGERS],
    count: usize,
    percept: Percept,
}

impl Perception {
    /// Perception for a hand that is wired like this; a sensor by itself feels for the fingers of an absent hand.
    #[must_use]
    pub fn new(wiring: &HandWiring, hand: &HandModel) -> Self {
        let mut percept = Percept::default();
        for (finger, side) in percept.presses_from[..hand.finger_count()]
            .iter_mut()
            .enumerate()
        {
            *side = hand.virtual_finger(finger);
        }
        Self {
            fingers: core::array::from_fn(|_| Finger::new(&wiring.layout)),
            count: wiring.fingers,
            percept,
        }
    }

    /// Begins a tick: no new frame yet.
    pub fn begin(&mut self) {
        self.percept.step_s = 0.0;
    }

    /// Takes in one frame. `slides` tells of an object that was seen to slide by other evidence than friction.
    pub fn update(&mut self, frame: &CheckedFrame<'_>, slides: bool, settings: &Settings) {
        for (index, finger) in self.fingers[..self.count].iter_mut().enumerate() {
            self.percept.fingers[index] = finger.update(index, frame, slides, settings);
        }
        for (side, felt) in self.percept.virtual_fingers.iter_mut().enumerate() {
            let fingers = self.percept.fingers[..self.count].iter();
            let of_side = fingers.zip(self.percept.presses_from);
            let of_side = of_side.filter_map(|(finger, from)| (from == side).then_some(finger));
            *felt = virtual_finger::together(of_side);
        }
        self.percept.captured_ns = frame.captured_ns();
        self.percept.step_s += frame.step_s();
    }

    /// What the hand feels now.
    #[must_use]
    pub fn percept(&self) -> &Percept {
        &self.percept
    }

    /// Takes the present filtered reading of every element as zero.
    pub fn bias(&mut self) {
        for finger in &mut self.fingers[..self.count] {
            finger.bias();
        }
    }
}
