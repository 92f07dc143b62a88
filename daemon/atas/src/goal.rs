//! Goals: what is asked is checked here, before anything moves.

use crate::wiring::Wiring;
use core::f64::consts::TAU;
use nalgebra::Vector3;
use robot_model::{GraspFrame, RobotModel, Side, Workspace};
use shm_schemas::{Cause, GoalKind, GoalPolicy, GoalRequest, GoalState, Reason};

/// Highest lift, m, and longest hold, s, that a goal may ask for (ours).
const LIFT_MAX_M: f64 = 0.15;
const HOLD_MAX_S: f64 = 3600.0;
/// Tasks that are built in.
const SUPPORTED: [GoalKind; 4] = [
    GoalKind::GRASP,
    GoalKind::PICK_PLACE,
    GoalKind::SCREW,
    GoalKind::RELEASE,
];
/// Index of each checked value in [`GoalRequest::VALUE_NAMES`].
const FROM_X: usize = 0;
const FROM_YAW: usize = 3;
const TO_X: usize = 4;
const TO_YAW: usize = 7;
const WIDTH: usize = 8;
const LIFT: usize = 9;
const HOLD: usize = 10;

/// The goal that is being pursued.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActiveGoal {
    /// What was asked.
    pub request: GoalRequest,
    /// Which hand.
    pub side: Side,
    /// Where it stands.
    pub state: GoalState,
    /// How long it has been paused in HOLD, s.
    pub paused_s: f64,
}

/// Checks a goal without moving anything: codes, numbers, sensors, reach. Takes some hundred microseconds because it
/// solves for the key postures, so call it off the tick.
///
/// # Errors
/// The [`Reason`] for the refusal.
pub fn check(goal: &GoalRequest, robot: &RobotModel, wiring: &Wiring) -> Result<Side, Reason> {
    let side = check_codes(goal)?;
    if let Some(index) = goal.values().iter().position(|v| !v.is_finite()) {
        return Err(Reason::of(Cause::NOT_FINITE).about(index));
    }
    if !wiring.hands[side.index()].required {
        return Err(Reason::of(Cause::NO_SENSOR).about(side.index()));
    }
    if goal.kind != GoalKind::RELEASE {
        check_range(goal.from_yaw_rad, (-TAU, TAU), FROM_YAW)?;
        check_range(goal.to_yaw_rad, (-TAU, TAU), TO_YAW)?;
        check_range(goal.lift_m, (0.0, LIFT_MAX_M), LIFT)?;
        check_range(goal.hold_s, (0.0, HOLD_MAX_S), HOLD)?;
        check_reach(goal, robot, side)?;
    }
    Ok(side)
}

fn check_codes(goal: &GoalRequest) -> Result<Side, Reason> {
    let unknown = |index: usize, code: u32| {
        Reason::limit(Cause::UNKNOWN_GOAL, f64::from(code), 0.0).about(index)
    };
    if !SUPPORTED.contains(&goal.kind) {
        return Err(unknown(0, goal.kind.0));
    }
    if !goal.turn.is_known() {
        return Err(unknown(3, goal.turn.0));
    }
    if !goal.policy.is_known() {
        return Err(unknown(2, goal.policy.0));
    }
    goal.hand
        .index()
        .map(|i| Side::BOTH[i])
        .ok_or(unknown(1, goal.hand.0))
}

fn check_range(value: f64, (lower, upper): (f64, f64), index: usize) -> Result<(), Reason> {
    let limit = if value < lower { lower } else { upper };
    if value >= lower && value <= upper {
        Ok(())
    } else {
        Err(Reason::limit(Cause::OUT_OF_RANGE, value, limit).about(index))
    }
}

/// Every place that the task takes the hand to must lie in the workspace, and the arm must have a posture for it.
fn check_reach(goal: &GoalRequest, robot: &RobotModel, side: Side) -> Result<(), Reason> {
    check_place(goal, robot, side, goal.from_m, goal.from_yaw_rad, FROM_X)?;
    if goal.kind == GoalKind::PICK_PLACE {
        check_place(goal, robot, side, goal.to_m, goal.to_yaw_rad, TO_X)?;
    }
    Ok(())
}

/// The hand must reach a place, and travel over it as high as the task lifts.
fn check_place(
    goal: &GoalRequest,
    robot: &RobotModel,
    side: Side,
    [x, y, z]: [f64; 3],
    yaw_rad: f64,
    index: usize,
) -> Result<(), Reason> {
    let hand = robot.hand(side);
    let workspace = Workspace::TWO_HAND_ARM;
    let (left, right) = (side == Side::Left, workspace.right_y_m);
    let y_m = if left { [-right[1], -right[0]] } else { right };
    let travel_m = travel_height_m(goal);
    let reach = |value: f64, [lower, upper]: [f64; 2], index: usize| {
        check_range(value, (lower, upper), index).map_err(|r| Reason {
            cause: Cause::UNREACHABLE,
            ..r
        })
    };
    reach(x, workspace.x_m, index)?;
    reach(y, y_m, index + 1)?;
    reach(z, workspace.z_m, index + 2)?;
    reach(travel_m, workspace.z_m, LIFT)?;
    reach(goal.width_m, workspace.opening_m, WIDTH)?;
    for height_m in [z, travel_m] {
        let centre_m = Vector3::new(x, y, height_m);
        let yaw_rad = hand.closing_yaw_rad(&centre_m, yaw_rad);
        let frame = GraspFrame::from_above(centre_m, yaw_rad, goal.width_m);
        if let Err(error) = hand.posture_for(&frame) {
            let error_m = error.best.tip_error_m;
            return Err(Reason::limit(Cause::UNREACHABLE, error_m, 0.0).about(index));
        }
    }
    Ok(())
}

/// Height of the grasp while the object is carried, m: `lift_m` over the higher of its places.
#[must_use]
pub fn travel_height_m(goal: &GoalRequest) -> f64 {
    let to_m = if goal.kind == GoalKind::PICK_PLACE {
        goal.to_m
    } else {
        goal.from_m
    };
    let highest_m = if to_m[2] > goal.from_m[2] {
        to_m[2]
    } else {
        goal.from_m[2]
    };
    highest_m + goal.lift_m
}

/// Whether the goal ends when its client goes away.
#[must_use]
pub fn is_attached(goal: &GoalRequest) -> bool {
    goal.policy == GoalPolicy::ATTACHED
}
