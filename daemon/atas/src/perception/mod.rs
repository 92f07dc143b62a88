//! Perception: computes the tactile state of a hand from validated frames.
//!
//! Inputs: the [`ValidatedFrame`]s of one hand in order, each exactly once (differences of repeated
//! samples would spike). Output: one [`Percept`] per tick. Windows and filters use sensor time, so
//! results do not depend on sensor or tick rate.
//!
//! The curvature of a fingertip would leak F_n·sin θ into the tangential force. Every element's
//! force is therefore rotated into the tip frame and split along the patch normal.

mod fingertip;
mod forces;
mod friction;
mod grasp_side;
mod increment;
mod lanes;
mod motion;
mod noise;
mod object_pose;
mod patch;
mod stiffness;
mod yield_detection;

pub use fingertip::{ContactPercept, FingertipPerception};
pub use motion::MotionPercept;
pub use object_pose::ObjectPose;
pub use stiffness::{LoadedArea, StiffnessEstimate, StiffnessFit, compression};
pub use yield_detection::{PressMaxima, YieldDetector, YieldRule};

use crate::intake::ValidatedFrame;
use crate::sensor_setup::HandSensorSetup;
use crate::settings::{self, Settings};
use patch::ElementAxes;
use robot_model::{GraspSide, HandModel, PerSide};
use shm_schemas::capacity::FINGERS;

/// Share of a new frame in the mean delay (design choice: a single late frame hardly counts).
const DELAY_SHARE: f64 = 1.0 / 16.0;

/// Tactile state of one hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Percept {
    /// Per fingertip; zero forces without a sensor.
    pub fingertips: [ContactPercept; FINGERS],
    /// Grasp side of each fingertip.
    pub side_of_fingertip: [GraspSide; FINGERS],
    /// Per grasp side, the combined percept of its fingertips.
    pub sides: PerSide<ContactPercept>,
    /// Sensor time of the newest frame, ns.
    pub captured_ns: u64,
    /// Sensor time that the newest frames of this tick cover, s; 0 without a frame.
    pub step_s: f64,
    /// Mean of frame period and frame age on arrival, s: time until the hand has read a touch.
    pub delay_s: f64,
}

impl Percept {
    /// Returns the speed, m/s, at which a motion travels `travel_m` before it can respond to a
    /// touch: within the delay of `frames` frames and the low-pass on the elements.
    #[must_use]
    pub fn touch_speed_m_s(&self, travel_m: f64, frames: u32, settings: &Settings) -> f64 {
        travel_m / (f64::from(frames) * self.delay_s + settings.perception.filter_s)
    }
}

/// Perception of one hand.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Perception {
    /// All fingertips of a hand have the same layout.
    axes: ElementAxes,
    fingertips: [FingertipPerception; FINGERS],
    count: usize,
    percept: Percept,
}

impl Perception {
    /// Creates the perception of a hand; also works for a sensor without a hand.
    #[must_use]
    pub fn new(wiring: &HandSensorSetup, hand: &HandModel) -> Self {
        let mut percept = Percept::default();
        for (finger, side) in percept.side_of_fingertip[..hand.fingertip_count()]
            .iter_mut()
            .enumerate()
        {
            *side = hand.grasp_side(finger);
        }
        percept.delay_s = 1.0 / wiring.rate_hz;
        Self {
            axes: ElementAxes::new(&wiring.layout),
            fingertips: Default::default(),
            count: wiring.fingers,
            percept,
        }
    }

    /// Begins a tick without a new frame.
    pub fn begin(&mut self) {
        self.percept.step_s = 0.0;
    }

    /// Adds one frame. `slips` reports slip detected without friction.
    pub fn update(&mut self, frame: &ValidatedFrame<'_>, slips: bool, settings: &Settings) {
        for (index, finger) in self.fingertips[..self.count].iter_mut().enumerate() {
            self.percept.fingertips[index] =
                *finger.update((index, &self.axes), frame, slips, settings);
        }
        for (side, measured) in GraspSide::BOTH.into_iter().zip(&mut self.percept.sides) {
            let fingers = self.percept.fingertips[..self.count].iter();
            let of_side = fingers.zip(self.percept.side_of_fingertip);
            let of_side = of_side.filter_map(|(finger, from)| (from == side).then_some(finger));
            *measured = grasp_side::combine(of_side);
        }
        let (percept, delay_s) = (&mut self.percept, frame.step_s() + frame.age_s());
        percept.captured_ns = frame.captured_ns();
        percept.step_s += frame.step_s();
        percept.delay_s += (delay_s - percept.delay_s) * DELAY_SHARE;
    }

    /// Returns the present percept.
    #[must_use]
    pub fn percept(&self) -> &Percept {
        &self.percept
    }

    /// Moves the zero of the fingertips towards the readings of the newest frames: of those without
    /// contact, or of all if the hand moves freely. Does nothing without a new frame.
    pub fn track_zero(&mut self, moves_freely: bool, settings: &settings::Perception) {
        if self.percept.step_s <= 0.0 {
            return;
        }
        for (finger, percept) in self.fingertips[..self.count]
            .iter_mut()
            .zip(&self.percept.fingertips)
        {
            if moves_freely || !percept.in_contact {
                finger.track_zero(self.axes.count, self.percept.step_s, settings);
            }
        }
    }

    /// Zeroes the filtered readings of all elements.
    pub fn bias(&mut self) {
        for finger in &mut self.fingertips[..self.count] {
            finger.bias();
        }
    }
}
