//! List of the built-in tasks, one per kind of goal.

use super::assemble::ASSEMBLE;
use super::fetch::FETCH;
use super::grasp::{GRASP, RELEASE};
use super::pick_place::{PICK_PLACE, SET_DOWN};
use super::screw::SCREW;
use super::step_sequence::Task;
use super::teleop::{TELEOP, TELEOP_BOTH};
use shm_schemas::GoalKind;

/// Built-in tasks.
pub static BUILT_IN: [&Task; 9] = [
    &GRASP,
    &FETCH,
    &PICK_PLACE,
    &SET_DOWN,
    &SCREW,
    &ASSEMBLE,
    &RELEASE,
    &TELEOP,
    &TELEOP_BOTH,
];

/// Returns the built-in task of a goal kind, or `None` for [`GoalKind::CUSTOM`] and unknown kinds.
///
/// ```
/// use atas_core::tasks::for_kind;
/// use shm_schemas::GoalKind;
///
/// let task = for_kind(GoalKind::GRASP).expect("a built-in task");
/// assert_eq!(task.name.as_str(), "grasp");
/// assert!(for_kind(GoalKind::CUSTOM).is_none());
/// ```
#[must_use]
pub fn for_kind(kind: GoalKind) -> Option<&'static Task> {
    by_name(kind.name())
}

/// Returns the built-in task of this name.
#[must_use]
pub fn by_name(name: &str) -> Option<&'static Task> {
    BUILT_IN.into_iter().find(|task| task.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_goal_kind_has_a_built_in_task() {
        for kind in GoalKind::ALL
            .iter()
            .filter(|kind| **kind != GoalKind::CUSTOM)
        {
            let task = for_kind(*kind).unwrap_or_else(|| panic!("{kind}: missing in BUILT_IN"));
            assert_eq!(task.name, kind.name());
        }
        assert_eq!(for_kind(GoalKind::CUSTOM), None);
    }
}
