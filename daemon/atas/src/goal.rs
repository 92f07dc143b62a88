//! Goals: what is asked is checked here, before anything moves.

use crate::wiring::Wiring;
use core::f64::consts::TAU;
use nalgebra::Vector3;
use robot_model::{GraspFrame, RobotModel, Side, Workspace};
use shm_schemas::{Cause, GoalKind, GoalPolicy, GoalRequest, GoalState, Reason};

/// Highest lift, m, and longest hold, s, that a goal may ask for (ours).
const LIFT_MAX_M: f64 = 0.15;
const HOLD_MAX_S: f64 = 3600.0;
/// Index of each checked value in [`GoalRequest::VALUE_NAMES`].
const FROM_X: usize = 0;
const FROM_YAW: usize = 3;
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
    if goal.kind == GoalKind::GRASP {
        check_range(goal.from_yaw_rad, (-TAU, TAU), FROM_YAW)?;
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
    if !matches!(goal.kind, GoalKind::GRASP | GoalKind::RELEASE) {
        return Err(unknown(0, goal.kind.0));
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

/// Both ends of the lift must lie in the workspace, and the arm must have a posture for each.
fn check_reach(goal: &GoalRequest, robot: &RobotModel, side: Side) -> Result<(), Reason> {
    let hand = robot.hand(side);
    let workspace = Workspace::TWO_HAND_ARM;
    let (left, right) = (side == Side::Left, workspace.right_y_m);
    let y_m = if left { [-right[1], -right[0]] } else { right };
    let [x, y, z] = goal.from_m;
    let reach = |value: f64, [lower, upper]: [f64; 2], index: usize| {
        check_range(value, (lower, upper), index).map_err(|r| Reason {
            cause: Cause::UNREACHABLE,
            ..r
        })
    };
    reach(x, workspace.x_m, FROM_X)?;
    reach(y, y_m, FROM_X + 1)?;
    reach(z, workspace.z_m, FROM_X + 2)?;
    reach(z + goal.lift_m, workspace.z_m, LIFT)?;
    reach(goal.width_m, workspace.opening_m, WIDTH)?;
    for height_m in [0.0, goal.lift_m] {
        let centre_m = Vector3::new(x, y, z + height_m);
        let yaw_rad = hand.closing_yaw_rad(&centre_m, goal.from_yaw_rad);
        let frame = GraspFrame::from_above(centre_m, yaw_rad, goal.width_m);
        if let Err(error) = hand.posture_for(&frame) {
            return Err(
                Reason::limit(Cause::UNREACHABLE, error.best.tip_error_m, 0.0).about(FROM_X),
            );
        }
    }
    Ok(())
}

/// Whether the goal ends when its client goes away.
#[must_use]
pub fn is_attached(goal: &GoalRequest) -> bool {
    goal.policy == GoalPolicy::ATTACHED
}
