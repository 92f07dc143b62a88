//! Step sequences and tasks with fixed capacity, so the tick needs no heap.

use super::name::Name;
use super::step::{Motion, Step, Transition};
use super::table::BehaviourTable;
use crate::modules::Selection;
use core::ops::Deref;

/// Maximum number of steps per hand.
pub const STEPS_MAX: usize = shm_schemas::capacity::STEPS;

/// Ordered steps of one hand; dereferences to a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StepSequence {
    steps: [Step; STEPS_MAX],
    count: usize,
}

impl Step {
    /// Filler of unused places.
    pub(crate) const NONE: Self =
        Self::new("", Motion::Stay, Selection::NONE, Transition::Arrived, 0.0);
}

impl StepSequence {
    /// Creates a sequence.
    ///
    /// # Panics
    /// If it has no step or more than [`STEPS_MAX`]; a compile error for constants.
    #[must_use]
    pub const fn from_steps(steps: &[Step]) -> Self {
        match Self::validated(steps) {
            Some(track) => track,
            None => panic!("a step sequence needs 1 to STEPS_MAX steps"),
        }
    }

    /// Creates a sequence if the number of steps is valid.
    #[must_use]
    pub const fn validated(steps: &[Step]) -> Option<Self> {
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

impl Deref for StepSequence {
    type Target = [Step];

    fn deref(&self) -> &[Step] {
        &self.steps[..self.count]
    }
}

/// Steps of both hands for a kind of goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task {
    /// Name shown to users.
    pub name: Name,
    /// Steps of the hand that the goal names.
    pub acting: StepSequence,
    /// Steps of the other hand, if it takes part.
    pub helping: Option<StepSequence>,
    /// Table for the behaviour table module.
    pub table: Option<BehaviourTable>,
}

impl Task {
    /// Creates a one-handed task.
    #[must_use]
    pub const fn one_handed(name: &str, steps: &[Step]) -> Self {
        Self {
            name: Name::new(name),
            acting: StepSequence::from_steps(steps),
            helping: None,
            table: None,
        }
    }
}
