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
mod patch;
mod stiffness;
mod yielding;

pub use finger::{Finger, FingerPercept};
pub use motion::MotionPercept;
pub use stiffness::{StiffnessEstimate, StiffnessFit};
pub use yielding::{YieldRule, YieldWatch, Yielded};

use crate::intake::CheckedFrame;
use crate::settings::Perception as Settings;
use crate::wiring::HandWiring;
use shm_schemas::capacity::FINGERS;

/// What one hand feels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Percept {
    /// Per finger; fingers without a sensor feel nothing.
    pub fingers: [FingerPercept; FINGERS],
    /// Sensor time of the newest frame, ns.
    pub captured_ns: u64,
    /// Sensor time that the newest frames of this tick cover, s; 0 when none arrived.
    pub step_s: f64,
}

/// One hand's perception.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Perception {
    fingers: [Finger; FINGERS],
    count: usize,
    percept: Percept,
}

impl Perception {
    /// Perception for a hand that is wired like this.
    #[must_use]
    pub fn new(wiring: &HandWiring) -> Self {
        Self {
            fingers: core::array::from_fn(|_| Finger::new(&wiring.layout)),
            count: wiring.fingers,
            percept: Percept::default(),
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
