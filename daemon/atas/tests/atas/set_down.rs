//! Set-down of an object in the hand: keeps the estimated object properties; an empty hand is
//! rejected.

use crate::world::{OBJECT_M, World, grasp, start};
use atas_core::tasks::{Motion, PICK_PLACE, SET_DOWN, Task};
use shm_schemas::{Cause, GoalKind, GoalRequest, GoalState, Mode, Text};

/// Set-down at the grasp position.
fn set_down() -> GoalRequest {
    GoalRequest {
        goal_id: 8,
        kind: GoalKind::CUSTOM,
        task: Text::new("set-down"),
        to_m: OBJECT_M,
        ..grasp()
    }
}

#[test]
fn it_ends_as_picking_and_placing_does() {
    let whole = PICK_PLACE.acting.to_vec();
    let end = whole.len() - SET_DOWN.acting.len();
    assert_eq!(SET_DOWN.acting.to_vec(), whole[end..]);
    assert!(SET_DOWN.demands().takes_over && SET_DOWN.demands().visits_source);
    assert!(!PICK_PLACE.demands().takes_over);
    let own = Task::checked("own", &SET_DOWN.acting, None).expect("a user may write it");
    assert_eq!(own.demands(), SET_DOWN.demands());
    assert_eq!(SET_DOWN.acting[0].motion, whole[end].motion);
    assert!(matches!(SET_DOWN.acting[0].motion, Motion::Convey(_)));
}

#[test]
fn an_empty_hand_has_nothing_to_set_down() {
    let mut world = World::ready();
    let update = world.order(start(set_down())).goal_update.expect("told");
    assert_eq!(update.state, GoalState::REJECTED);
    assert_eq!(
        (update.reason.cause, update.reason.index),
        (Cause::HAND_EMPTY, 1)
    );
    assert_eq!(world.mode(), Mode::READY, "nothing moves");
}

#[test]
fn what_the_hand_holds_is_set_down_with_what_was_learnt_of_it() {
    let mut world = World::holding();
    let before = world.run(1).report.hands[1];
    let outputs = world.order(start(set_down()));
    let update = outputs.goal_update.expect("told");
    assert_eq!(update.state, GoalState::ACCEPTED, "{}", update.reason);
    let after = world.run(1).report.hands[1];
    assert_eq!((after.f1_n, after.f2_n), (before.f1_n, before.f2_n));
    assert_eq!(after.stiffness_n_m, before.stiffness_n_m);
    assert!(
        (after.fingers[0].normal_n - before.fingers[0].normal_n).abs() < 0.1,
        "it keeps its grip"
    );
    let (outputs, _) = world.run_until(60_000, |world| {
        world.controller.goal().expect("a goal").state.is_final()
    });
    let update = outputs.goal_update.expect("told");
    assert_eq!(update.state, GoalState::SUCCEEDED, "{}", update.reason);
    assert!(
        outputs.report.hands[1]
            .fingers
            .iter()
            .all(|f| f.in_contact == 0)
    );
}
