//! The list of the built-in tasks: what a kind of goal makes the hands do.

use super::assemble::ASSEMBLE;
use super::grasp::{GRASP, RELEASE};
use super::pick_place::PICK_PLACE;
use super::screw::SCREW;
use super::track::Task;
use shm_schemas::GoalKind;

/// The built-in tasks.
pub static BUILT_IN: [&Task; 5] = [&GRASP, &PICK_PLACE, &SCREW, &ASSEMBLE, &RELEASE];

/// The built-in task of a kind of goal; `None` for a user's own and for an unknown kind.
#[must_use]
pub fn of(kind: GoalKind) -> Option<&'static Task> {
    BUILT_IN.into_iter().find(|task| task.name == kind.name())
}
