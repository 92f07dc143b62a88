//! Limits of gripper commands: opening of the hand, smallest grip force.

use atas_client::Session;
use robot_model::HandSide;
use shm_schemas::{ControlOp, Hand};

use super::scene::Scene;

/// Name of the parameter with the smallest grip force.
const FORCE_MIN: &str = "grasp.carry_min_n";

/// Returns the side of a hand.
pub(super) fn side(hand: Hand) -> HandSide {
    HandSide::BOTH[hand.index().unwrap_or(0)]
}

/// Returns the force of the stronger grasp side, N.
pub(super) fn force_n(hand: Hand, scene: &Scene) -> f64 {
    let index = hand.index().unwrap_or(0);
    let Some(robot) = scene.robot() else {
        return 0.0;
    };
    let normal_n = &scene.status.hands[index].normal_n;
    let sides = robot.model.hand(side(hand)).grasp_sides();
    let sums_n = sides.sums(|tip| normal_n.get(tip).copied().unwrap_or(0.0).into());
    sums_n.into_iter().fold(0.0, f64::max)
}

pub(super) fn check_opening(opening_m: f64, hand: Hand, scene: &Scene) -> Result<(), String> {
    let Some(robot) = scene.robot() else {
        return Ok(());
    };
    let most_m = robot.model.hand(side(hand)).max_opening_m();
    if (0.0..=most_m).contains(&opening_m) {
        return Ok(());
    }
    Err(format!(
        "goal rejected: position is {opening_m:.4} m, outside 0 to {most_m:.4} m, the opening of \
         the {hand} hand"
    ))
}

pub(super) fn check_force(max_force_n: f64, session: &Session) -> Result<(), String> {
    if max_force_n == 0.0 {
        return Ok(());
    }
    let reply = session.request_success(ControlOp::PARAM_GET, 0.0, FORCE_MIN);
    let least_n = reply
        .map_err(|error| format!("goal not sent: {error}"))?
        .value;
    if max_force_n >= least_n {
        return Ok(());
    }
    Err(format!(
        "goal rejected: max_effort is {max_force_n} N, below the smallest grip force, {least_n} N \
         ({FORCE_MIN}); command more, or 0 without limit"
    ))
}
