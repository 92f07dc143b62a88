//! The list of the built-in tasks: what a kind of goal makes the hands do.

use super::assemble::ASSEMBLE;
use super::fetch::FETCH;
use super::follow::{FOLLOW, FOLLOW_BOTH};
use super::grasp::{GRASP, RELEASE};
use super::pick_place::{PICK_PLACE, SET_DOWN};
use super::screw::SCREW;
use super::track::Task;
use shm_schemas::GoalKind;

/// The built-in tasks.
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

/// The built-in task of a kind of goal; `None` for [`GoalKind::CUSTOM`] and for an unknown kind.
#[must_use]
pub fn of(kind: GoalKind) -> Option<&'static Task> {
    named(kind.name())
}

/// The built-in task of this name.
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
