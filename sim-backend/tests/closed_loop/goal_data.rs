//! Optional goal data: object height and tolerated force.

use crate::rig::{Rig, displace, goal, object};
use robot_model::HandSide;
use shm_schemas::{Cause, GoalKind, GoalRequest, GoalState, ObjectTruth};
use sim_backend::{Object, Scene, Shape};

/// Grasps an object with a changed goal; returns outcome and ground truth.
fn grasped(
    object: Object,
    output: impl FnOnce(&mut GoalRequest),
) -> (GoalState, Cause, ObjectTruth) {
    let scene = Scene::grasp(object, HandSide::Right);
    let mut goal = goal(GoalKind::GRASP, &scene, HandSide::Right);
    output(&mut goal);
    let mut rig = Rig::seeded(&scene, 1);
    let end = rig.execute(&goal);
    (end.state, end.reason.cause, rig.object())
}

/// Returns a wooden post of this height.
fn post(height_m: f64) -> Object {
    let mut post = object("wood");
    let Shape::Box { half_m } = &mut post.shape else {
        panic!("wood is a box");
    };
    half_m.z = height_m / 2.0;
    post
}

/// Regression: the hand moved from its rest position straight to the approach point and hit a high
/// object from the side.
#[test]
fn hand_approaches_high_objects_from_above() {
    for height_m in [0.15, 0.18, 0.20] {
        let (state, cause, truth) = grasped(post(height_m), |_| ());
        let what = format!("{height_m} m: {state} {cause}");
        assert_eq!(state, GoalState::SUCCEEDED, "{what}");
        assert!(truth.lifted_m > 0.03 && truth.dropped == 0, "{what}");
    }
}

/// Regression: an object that stands 8 mm beside its place was reported as an obstacle.
#[test]
fn touched_object_is_grasped_beside_the_touch() {
    for (y_mm, yaw_deg) in [(8.0, 0.0), (-8.0, 0.0), (0.0, 20.0), (6.0, 15.0)] {
        let mut scene = Scene::grasp(post(0.12), HandSide::Right);
        let goal = goal(GoalKind::GRASP, &scene, HandSide::Right);
        displace(&mut scene, 0, [0.0, y_mm, yaw_deg]);
        let mut rig = Rig::seeded(&scene, 1);
        let end = rig.execute(&goal);
        let what = format!("{y_mm} mm, {yaw_deg}°: {}", end.reason);
        assert_eq!(end.state, GoalState::SUCCEEDED, "{what}");
        let truth = rig.object();
        assert!(truth.lifted_m > 0.03 && truth.tipped == 0, "{what}");
    }
}

/// A grasp far below an object's top hits it from above unless the goal states the height.
#[test]
fn deep_grasp_requires_the_object_height() {
    let deep = |goal: &mut GoalRequest| goal.from_m[2] = 0.10;
    let (_, cause, _) = grasped(post(0.17), deep);
    assert_eq!(cause, Cause::OBSTRUCTED);
    let (state, cause, truth) = grasped(post(0.17), |goal| {
        deep(goal);
        goal.top_m = 0.07;
    });
    assert_eq!((state, cause), (GoalState::SUCCEEDED, Cause::NONE));
    assert!(truth.lifted_m > 0.03);
}

/// Regression: a soft ball that needs 1 N and tolerates 4 N was rejected despite the stated force
/// limit.
#[test]
fn goal_may_raise_the_force_limit() {
    let ball = || Object {
        stiffness_n_m: 800.0,
        mass_kg: 0.12,
        friction: 0.6,
        crush_n: 4.0,
        ..object("sponge")
    };
    let (state, cause, _) = grasped(ball(), |_| ());
    assert_eq!((state, cause), (GoalState::REFUSED, Cause::TOO_SOFT));
    for (max_force_n, expected) in [
        (3.5, (GoalState::SUCCEEDED, Cause::NONE)),
        (0.8, (GoalState::REFUSED, Cause::ABOVE_MAX_FORCE)),
    ] {
        let (state, cause, truth) = grasped(ball(), |goal| goal.max_force_n = max_force_n);
        assert_eq!((state, cause), expected, "stated limit {max_force_n} N");
        assert_eq!((truth.crushed, truth.dropped), (0, 0));
        let most_n = truth.max_force_n;
        assert!(
            most_n < 1.08 * max_force_n,
            "{most_n} N, stated limit {max_force_n}"
        );
    }
}

/// The stated force limit holds even for a stiff object.
#[test]
fn goal_may_lower_the_force_limit() {
    for (name, max_force_n) in [("wood", 1.5), ("heavy-block", 3.0), ("heavy-block", 7.0)] {
        let (state, cause, truth) = grasped(object(name), |goal| goal.max_force_n = max_force_n);
        let what = format!(
            "{name}, stated limit {max_force_n} N: pressed with {} N",
            truth.max_force_n
        );
        assert_eq!(
            (state, cause),
            (GoalState::REFUSED, Cause::ABOVE_MAX_FORCE),
            "{what}"
        );
        assert!(truth.max_force_n < 1.08 * max_force_n, "{what}");
    }
}
