//! Set-down of an object in the hand: keeps the estimated object properties; an empty hand is
//! rejected.

use crate::world::{OBJECT_M, World, grasp, start};
use atas_core::tasks::{Motion, PICK_PLACE, SET_DOWN, Task};
use shm_schemas::{GoalKind, GoalRequest, GoalState, Hand, Mode, Reason, Text};

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
fn set_down_ends_like_pick_and_place() {
    let whole = PICK_PLACE.acting.to_vec();
    let end = whole.len() - SET_DOWN.acting.len();
    assert_eq!(SET_DOWN.acting.to_vec(), whole[end..]);
    assert!(SET_DOWN.requirements().starts_with_object && SET_DOWN.requirements().visits_source);
    assert!(!PICK_PLACE.requirements().starts_with_object);
    let own = Task::validated("own", &SET_DOWN.acting, None).expect("a valid user task");
    assert_eq!(own.requirements(), SET_DOWN.requirements());
    assert_eq!(SET_DOWN.acting[0].motion, whole[end].motion);
    assert!(matches!(SET_DOWN.acting[0].motion, Motion::Convey(_)));
}

#[test]
fn set_down_with_empty_hand_is_rejected() {
    let mut world = World::ready();
    let update = world
        .request(start(set_down()))
        .goal_update
        .expect("goal update");
    assert_eq!(update.state, GoalState::REJECTED);
    let empty = Reason::HandEmpty { hand: Hand::RIGHT };
    assert_eq!(Reason::from(update.reason), empty);
    assert_eq!(world.mode(), Mode::READY, "no motion");
}

#[test]
fn set_down_keeps_the_object_estimates() {
    let mut world = World::holding();
    let before = world.run(1).report.hands[1];
    let outputs = world.request(start(set_down()));
    let update = outputs.goal_update.expect("goal update");
    assert_eq!(update.state, GoalState::ACCEPTED, "{}", update.reason);
    let after = world.run(1).report.hands[1];
    assert_eq!((after.f1_n, after.f2_n), (before.f1_n, before.f2_n));
    assert_eq!(after.stiffness_n_m, before.stiffness_n_m);
    assert!(
        (after.fingers[0].normal_n - before.fingers[0].normal_n).abs() < 0.1,
        "keeps its grip"
    );
    let (outputs, _) = world.run_until(60_000, |world| {
        world.controller.goal().expect("a goal").state.is_final()
    });
    let update = outputs.goal_update.expect("goal update");
    assert_eq!(update.state, GoalState::SUCCEEDED, "{}", update.reason);
    assert!(
        outputs.report.hands[1]
            .fingers
            .iter()
            .all(|f| f.in_contact == 0)
    );
}
