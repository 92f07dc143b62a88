//! Goals that a client with nominal knowledge of the scene requests.

use atas_client::goal::{self, Target};
use robot_model::HandSide;
use shm_schemas::{GoalRequest, Hand};
use sim_backend::GraspHint;

fn target(hint: &GraspHint) -> Target {
    Target {
        at_m: hint.from_m,
        yaw_rad: hint.yaw_rad,
        width_m: hint.width_m,
        ..Target::default()
    }
    .with_limits((hint.height_m - hint.from_m[2]).max(0.0), 0.0)
}

/// Returns a client's goal to grasp an object at its expected place.
#[must_use]
pub fn grasp_goal(hint: &GraspHint, side: HandSide, lift_m: f64, hold_s: f64) -> GoalRequest {
    goal::grasp(&target(hint), Hand::BOTH[side.index()], lift_m, hold_s)
}

/// Returns a client's goal to carry an object; `place` is the final pose of the fingertips.
#[must_use]
pub fn pick_place_goal(
    hint: &GraspHint,
    side: HandSide,
    place: &GraspHint,
    lift_m: f64,
) -> GoalRequest {
    let hand = Hand::BOTH[side.index()];
    GoalRequest {
        to_yaw_rad: place.yaw_rad,
        ..goal::pick_place(&target(hint), hand, place.from_m, lift_m)
    }
}

/// Returns a client's goal to set down the object grasped at `hint`.
#[must_use]
pub fn set_down_goal(hint: &GraspHint, side: HandSide, to_m: [f64; 3], lift_m: f64) -> GoalRequest {
    goal::set_down(&target(hint), Hand::BOTH[side.index()], to_m, lift_m)
}

/// Returns a client's goal to close a cap in place.
#[must_use]
pub fn screw_goal(hint: &GraspHint, side: HandSide) -> GoalRequest {
    goal::screw(&target(hint), Hand::BOTH[side.index()])
}

/// Returns a client's goal to close a bottle with a cap from its stand; see [`goal::assemble`].
#[must_use]
pub fn assemble_goal(
    cap: &GraspHint,
    on_bottle: &GraspHint,
    bottle_width_m: f64,
    screws: HandSide,
) -> GoalRequest {
    let (cap, on_bottle) = (target(cap), target(on_bottle));
    goal::assemble(&cap, &on_bottle, bottle_width_m, Hand::BOTH[screws.index()])
}
