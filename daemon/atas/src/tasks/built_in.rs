//! List of the built-in tasks, one per kind of goal.

use super::assemble::ASSEMBLE;
use super::fetch::FETCH;
use super::follow::{FOLLOW, FOLLOW_BOTH};
use super::grasp::{GRASP, RELEASE};
use super::pick_place::{PICK_PLACE, SET_DOWN};
use super::screw::SCREW;
use super::track::Task;
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
    &FOLLOW,
    &FOLLOW_BOTH,
];

/// Returns the built-in task of a goal kind, or `None` for [`GoalKind::CUSTOM`] and unknown kinds.
#[must_use]
pub fn of(kind: GoalKind) -> Option<&'static Task> {
    named(kind.name())
}

/// Returns the built-in task of this name.
#[must_use]
pub fn named(name: &str) -> Option<&'static Task> {
    BUILT_IN.into_iter().find(|task| task.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_goal_has_the_task_of_its_name() {
        for kind in GoalKind::ALL
            .iter()
            .filter(|kind| **kind != GoalKind::CUSTOM)
        {
            let task = of(*kind).unwrap_or_else(|| panic!("{kind}: add its task to the list"));
            assert_eq!(task.name, kind.name());
        }
        assert_eq!(of(GoalKind::CUSTOM), None);
    }
}
