//! Validated tactile frame.

use shm_schemas::HandFrame;
use shm_schemas::capacity::{ELEMENTS, FINGERS};

/// Tactile frame that passed every check; created by [`super::FrameIntake`] only. Invalid elements
/// are masked out.
#[derive(Clone, Copy, Debug)]
pub struct ValidatedFrame<'a> {
    pub(super) frame: &'a HandFrame,
    pub(super) mask: [u64; FINGERS],
    pub(super) step_s: f64,
    pub(super) age_s: f64,
}

impl ValidatedFrame<'_> {
    /// Returns the force of one element `[f_n, f_t1, f_t2]`, N, or `None` if it is masked out.
    #[must_use]
    pub fn element_n(&self, finger: usize, element: usize) -> Option<[f64; 3]> {
        (self.mask[finger] >> element & 1 == 1)
            .then(|| self.frame.force_n[finger][element].map(f64::from))
    }

    /// Returns the raw forces of one fingertip, N, and its mask of valid elements.
    #[must_use]
    pub fn readings_n(&self, finger: usize) -> (&[[f32; 3]; ELEMENTS], u64) {
        (&self.frame.force_n[finger], self.mask[finger])
    }

    /// Sensor time since the previous frame, s. Includes lost frames; long pauses are clipped.
    #[must_use]
    pub fn step_s(&self) -> f64 {
        self.step_s
    }

    /// Time from sampling to this tick, s; zero for a sensor clock that leads.
    #[must_use]
    pub fn age_s(&self) -> f64 {
        self.age_s
    }

    /// Sampling time of the sensor, ns.
    #[must_use]
    pub fn captured_ns(&self) -> u64 {
        self.frame.stamp.captured_ns
    }
}
