//! Tasks of fixed capacity, so that a user's task can be handed to the tick without the heap.

use super::{Motion, Name, Step, Until};
use crate::modules::Selection;
use core::ops::Deref;

/// Most steps of one hand's track (ours: twice what the longest built-in task needs).
pub const STEPS_MAX: usize = 32;

/// The steps of one hand, in order; reads as a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Track {
    steps: [Step; STEPS_MAX],
    count: usize,
}

/// What stands in the unused places of a track.
const NO_STEP: Step = Step::new("", Motion::Stay, Selection::NONE, Until::Arrived, 0.0);

impl Track {
    /// A track of these steps.
    ///
    /// # Panics
    /// When it has no step or more than [`STEPS_MAX`]: for a table in the code this fails while it compiles.
    #[must_use]
    pub const fn of(steps: &[Step]) -> Self {
        assert!(!steps.is_empty() && steps.len() <= STEPS_MAX);
        let mut track = Self {
            steps: [NO_STEP; STEPS_MAX],
            count: steps.len(),
        };
        let mut i = 0;
        while i < steps.len() {
            track.steps[i] = steps[i];
            i += 1;
        }
        track
    }
}

impl Deref for Track {
    type Target = [Step];

    fn deref(&self) -> &[Step] {
        &self.steps[..self.count]
    }
}

/// What a goal makes the hands do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task {
    /// Name, as users see it.
    pub name: Name,
    /// Steps of the hand that the goal names.
    pub acting: Track,
    /// Steps of the other hand, if it helps.
    pub helping: Option<Track>,
}

impl Task {
    /// A task of one hand.
    #[must_use]
    pub const fn of(name: &str, steps: &[Step]) -> Self {
        Self {
            name: Name::new(name),
            acting: Track::of(steps),
            helping: None,
        }
    }
}
