//! Perception: computes the tactile state of a hand from validated frames.
//!
//! Inputs: the [`CheckedFrame`]s of one hand in order, each exactly once (differences of repeated
//! samples would spike). Output: one [`Percept`] per tick. Windows and filters use sensor time, so
//! results do not depend on sensor or tick rate.
//!
//! The curvature of a fingertip would leak F_n·sin θ into the tangential force. Every element's
//! force is therefore rotated into the tip frame and split along the patch normal.

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

/// Tactile state of one hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Percept {
    /// Per fingertip; zero forces without a sensor.
    pub fingers: [FingerPercept; FINGERS],
    /// Grasp side of each fingertip, 0 or 1.
    pub presses_from: [usize; FINGERS],
    /// Per grasp side, the combined percept of its fingertips.
    pub virtual_fingers: [FingerPercept; VIRTUAL_FINGERS],
    /// Sensor time of the newest frame, ns.
    pub captured_ns: u64,
    /// Sensor time that the newest frames of this tick cover, s; 0 without a frame.
    pub step_s: f64,
}

/// Perception of one hand.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Perception {
    fingers: [Finger; FINGERS],
    count: usize,
    percept: Percept,
}

impl Perception {
    /// Creates the perception of a hand; also works for a sensor without a hand.
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

    /// Begins a tick without a new frame.
    pub fn begin(&mut self) {
        self.percept.step_s = 0.0;
    }

    /// Adds one frame. `slips` reports slip detected without friction.
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

    /// Returns the present percept.
    #[must_use]
    pub fn percept(&self) -> &Percept {
        &self.percept
    }

    /// Zeroes the filtered readings of all elements.
    pub fn bias(&mut self) {
        for finger in &mut self.fingers[..self.count] {
            finger.bias();
        }
    }
}
