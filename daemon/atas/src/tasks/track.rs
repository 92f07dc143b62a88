//! Tasks of fixed capacity, so that a user's task can be handed to the tick without the heap.

use super::name::Name;
use super::step::{Motion, Step, Transition};
use super::table::BehaviourTable;
use crate::modules::Selection;
use core::ops::Deref;

/// Most steps of one hand's track.
pub const STEPS_MAX: usize = shm_schemas::capacity::STEPS;

/// The steps of one hand, in order; reads as a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Track {
    steps: [Step; STEPS_MAX],
    count: usize,
}

impl Step {
    /// What stands in the unused places of a track.
    pub(crate) const NONE: Self =
        Self::new("", Motion::Stay, Selection::NONE, Transition::Arrived, 0.0);
}

impl Track {
    /// A track of these steps.
    ///
    /// # Panics
    /// When it has no step or more than [`STEPS_MAX`]: for a table in the code this fails while it compiles.
    #[must_use]
    pub const fn of(steps: &[Step]) -> Self {
        match Self::checked(steps) {
            Some(track) => track,
            None => panic!("a track needs 1 to STEPS_MAX steps"),
        }
    }

    /// A track of these steps, if it is not empty and they fit.
    #[must_use]
    pub const fn checked(steps: &[Step]) -> Option<Self> {
        if steps.is_empty() || steps.len() > STEPS_MAX {
            return None;
        }
        let mut track = Self {
            steps: [Step::NONE; STEPS_MAX],
            count: steps.len(),
        };
        let mut i = 0;
        while i < steps.len() {
            track.steps[i] = steps[i];
            i += 1;
        }
        Some(track)
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
    /// What the module "behaviour table" reads, if a step has it.
    pub table: Option<BehaviourTable>,
}

impl Task {
    /// A task of one hand.
    #[must_use]
    pub const fn of(name: &str, steps: &[Step]) -> Self {
        Self {
            name: Name::new(name),
            acting: Track::of(steps),
            helping: None,
            table: None,
        }
    }
}
