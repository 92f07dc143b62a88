//! Placing without a support at the expected height.

use crate::rig::{Rig, goal, object};
use robot_model::HandSide;
use shm_schemas::{Cause, GoalKind, GoalState};
use sim_backend::Scene;

#[test]
fn object_without_support_is_raised_and_kept() {
    let mut scene = Scene::pick_place(object("wood"), HandSide::Right);
    scene.plates.truncate(1);
    let mut rig = Rig::new(&scene);
    let mut goal = goal(GoalKind::PICK_PLACE, &scene, HandSide::Right);
    // 10 mm of missing plate and 20 mm more: below the controller's search range.
    goal.to_m[2] += 0.020;
    let end = rig.execute(&goal);
    assert_eq!(
        (end.state, end.reason.cause),
        (GoalState::FAILED, Cause::NO_SUPPORT),
        "{}",
        end.reason
    );
    rig.ticks(3000);
    let object = rig.object();
    assert!(object.lifted_m > 0.05, "{object:?}");
    assert_eq!((object.dropped, object.crushed), (0, 0));
}

#[test]
fn lower_place_is_found() {
    let mut scene = Scene::pick_place(object("wood"), HandSide::Right);
    scene.plates.truncate(1);
    let mut rig = Rig::new(&scene);
    rig.execute_successfully(&goal(GoalKind::PICK_PLACE, &scene, HandSide::Right));
    let object = rig.object();
    assert!((object.lifted_m + 0.010).abs() < 5e-4, "{object:?}");
    assert_eq!((object.dropped, object.tipped), (0, 0));
}
