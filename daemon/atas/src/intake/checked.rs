//! A frame that is believed: only [`super::FrameIntake`] makes one.

use shm_schemas::HandFrame;
use shm_schemas::capacity::{ELEMENTS, FINGERS};

/// A frame that passed every check. Invalid elements are masked out.
#[derive(Clone, Copy, Debug)]
pub struct CheckedFrame<'a> {
    pub(super) frame: &'a HandFrame,
    pub(super) mask: [u64; FINGERS],
    pub(super) step_s: f64,
}

impl CheckedFrame<'_> {
    /// Force of one element `[f_n, f_t1, f_t2]`, N; `None` if the element is masked out.
    #[must_use]
    pub fn element_n(&self, finger: usize, element: usize) -> Option<[f64; 3]> {
        (self.mask[finger] >> element & 1 == 1)
            .then(|| self.frame.force_n[finger][element].map(f64::from))
    }

    /// All forces of one finger, N, as the sensor said them, and which elements are to be believed.
    #[must_use]
    pub fn readings_n(&self, finger: usize) -> (&[[f32; 3]; ELEMENTS], u64) {
        (&self.frame.force_n[finger], self.mask[finger])
    }

    /// Sensor time since the frame before, s; lost frames included, long pauses cut.
    #[must_use]
    pub fn step_s(&self) -> f64 {
        self.step_s
    }

    /// When the sensor sampled, ns.
    #[must_use]
    pub fn captured_ns(&self) -> u64 {
        self.frame.stamp.captured_ns
    }
}
