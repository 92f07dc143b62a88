//! Goals: what is asked is checked here, before anything moves.

use crate::tasks::from_the_side;
use crate::wiring::Wiring;
use core::f64::consts::TAU;
use nalgebra::Vector3;
use robot_model::{GraspFrame, RobotModel, Side, Unreachable, Workspace, clearance_m};
use shm_schemas::{Cause, GoalKind, GoalPolicy, GoalRequest, GoalState, Reason};

/// Highest lift, m, and longest hold, s, that a goal may ask for (ours).
const LIFT_MAX_M: f64 = 0.15;
const HOLD_MAX_S: f64 = 3600.0;
/// Tasks that are built in.
const SUPPORTED: [GoalKind; 5] = [
    GoalKind::GRASP,
    GoalKind::PICK_PLACE,
    GoalKind::SCREW,
    GoalKind::ASSEMBLE,
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
const HELPER_WIDTH: usize = 11;
/// Least distance between the arms, m (robot design: the proved motions keep 24 mm).
const CLEARANCE_M: f64 = 0.010;
/// How much wider than the cap the acting hand is while both hands are over the bottle, m.
const OPENINGS_M: [f64; 2] = [0.0, 0.024];

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

impl ActiveGoal {
    /// Whether this hand takes part.
    #[must_use]
    pub fn involves(&self, side: Side) -> bool {
        side == self.side || self.request.kind == GoalKind::ASSEMBLE
    }
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
    if goal.kind == GoalKind::ASSEMBLE {
        let helper = Side::BOTH[1 - side.index()];
        if !wiring.hands[helper.index()].required {
            return Err(Reason::of(Cause::NO_SENSOR).about(helper.index()));
        }
        check_together(goal, robot, side, helper)?;
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
    if goes_elsewhere(goal.kind) {
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

/// The helping hand must reach the bottle, and the arms must keep clear of each other while both are over it.
fn check_together(
    goal: &GoalRequest,
    robot: &RobotModel,
    side: Side,
    helper: Side,
) -> Result<(), Reason> {
    let [least_m, most_m] = Workspace::TWO_HAND_ARM.opening_m;
    check_range(goal.helper_width_m, (least_m, most_m), HELPER_WIDTH)?;
    let (acting, helping) = (robot.hand(side), robot.hand(helper));
    let unreachable = |error: Unreachable| {
        Reason::limit(Cause::UNREACHABLE, error.best.tip_error_m, 0.0).about(TO_X)
    };
    let held = helping
        .posture_for(&from_the_side(helping, goal, 0.0))
        .map_err(unreachable)?;
    let held = helping.capsules(&helping.forward(&held.q_rad));
    let [x, y, z] = goal.to_m;
    let heights_m = [0.0, 0.5, 1.0].map(|share| z + share * (travel_height_m(goal) - z));
    for (height_m, opening_m) in heights_m
        .into_iter()
        .flat_map(|z| OPENINGS_M.map(|o| (z, o)))
    {
        let centre_m = Vector3::new(x, y, height_m);
        let yaw_rad = acting.closing_yaw_rad(&centre_m, goal.to_yaw_rad);
        let frame = GraspFrame::from_above(centre_m, yaw_rad, goal.width_m + opening_m);
        let posture = acting.posture_for(&frame).map_err(unreachable)?;
        let clear_m = clearance_m(&acting.capsules(&acting.forward(&posture.q_rad)), &held);
        if clear_m < CLEARANCE_M {
            return Err(Reason::limit(Cause::ARMS_COLLIDE, clear_m, CLEARANCE_M));
        }
    }
    Ok(())
}

/// Whether a task carries the object to another place.
#[must_use]
pub fn goes_elsewhere(kind: GoalKind) -> bool {
    matches!(kind, GoalKind::PICK_PLACE | GoalKind::ASSEMBLE)
}

/// Height of the grasp while the object is carried, m: `lift_m` over the higher of its places.
#[must_use]
pub fn travel_height_m(goal: &GoalRequest) -> f64 {
    let to_m = if goes_elsewhere(goal.kind) {
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
