//! Whether a goal can be pursued, checked before anything moves.
//!
//! In: what a client sent and the [`Circumstances`]. Out: a [`Goal`], or the [`Reason`] against it. The checks come in the
//! order in which a client would mend them: codes, numbers, sensors, reach, paths. Everything takes some milliseconds, so
//! it is called off the tick; nothing here changes anything.

mod circumstances;
mod clearance;
mod fields;

pub use circumstances::Circumstances;

use crate::follow::{FollowSpace, across_the_middle};
use crate::goal::Goal;
use crate::kinematics::frame_of;
use clearance::check_paths;
use core::f64::consts::TAU;
use fields::{FROM_X, FROM_YAW, HELPER_WIDTH, HOLD, LIFT, TO_X, TO_YAW, WIDTH};
use nalgebra::Vector3;
use robot_model::{GraspFrame, Side, Workspace};
use shm_schemas::{Cause, GoalRequest, Reason};

/// Highest lift, m, and longest hold, s, that a goal may ask for (ours).
const LIFT_MAX_M: f64 = 0.15;
const HOLD_MAX_S: f64 = 3600.0;

/// Checks a goal without moving anything: codes, numbers, sensors, reach, clearance. Takes some
/// milliseconds because it follows every path of the task, so call it off the tick.
///
/// # Errors
/// The [`Reason`] for the refusal.
pub fn check(request: &GoalRequest, now: &Circumstances<'_>) -> Result<Goal, Reason> {
    let goal = Goal::resolve(request, now.tasks)?;
    if let Some(index) = request.values().iter().position(|v| !v.is_finite()) {
        return Err(Reason::of(Cause::NOT_FINITE).about(index));
    }
    let hands = Side::BOTH.map(|side| (side, side == goal.side() || goal.demands().both_hands));
    for (side, takes_part) in hands {
        if takes_part && !now.wiring.hands[side.index()].required {
            return Err(Reason::of(Cause::NO_SENSOR).about(side.index()));
        }
    }
    let visits = goal.demands().visits_source || goal.demands().visits_target;
    if visits || goal.demands().both_hands {
        check_range(request.from_yaw_rad, (-TAU, TAU), FROM_YAW)?;
        check_range(request.to_yaw_rad, (-TAU, TAU), TO_YAW)?;
        check_range(request.lift_m, (0.0, LIFT_MAX_M), LIFT)?;
        check_range(request.hold_s, (0.0, HOLD_MAX_S), HOLD)?;
        check_reach(&goal, now)?;
    }
    if goal.demands().both_hands {
        let [least_m, most_m] = Workspace::TWO_HAND_ARM.opening_m;
        check_range(request.helper_width_m, (least_m, most_m), HELPER_WIDTH)?;
    }
    if request.kind.is_stream() {
        check_sides(&goal, now)?;
    }
    check_paths(&goal, now)?;
    Ok(goal)
}

/// Where a client will lead the hands is not known: each arm must be on its own side of the table, each led hand in its box.
fn check_sides(goal: &Goal, now: &Circumstances<'_>) -> Result<(), Reason> {
    for side in Side::BOTH {
        let (hand, q_rad) = (now.robot.hand(side), now.hand_rad(side));
        if let Some(reason) = across_the_middle(hand, &q_rad) {
            return Err(reason);
        }
        let led = side == goal.side() || goal.demands().both_hands;
        let centre_m = frame_of(hand, &hand.forward(&q_rad)).centre_m;
        let [_, [least_m, most_m], _] = FollowSpace::of(side).centre_m;
        if led && !(least_m..=most_m).contains(&centre_m.y) {
            let (inner_m, y_m) = (least_m.abs().min(most_m.abs()), centre_m.y.abs());
            return Err(Reason::limit(Cause::ACROSS_THE_MIDDLE, y_m, inner_m).about(side.index()));
        }
    }
    Ok(())
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
fn check_reach(goal: &Goal, now: &Circumstances<'_>) -> Result<(), Reason> {
    let request = goal.request();
    if goal.demands().visits_source {
        check_place(goal, now, request.from_m, request.from_yaw_rad, FROM_X)?;
    }
    if goal.demands().visits_target {
        check_place(goal, now, request.to_m, request.to_yaw_rad, TO_X)?;
    }
    Ok(())
}

/// The hand must reach a place, and travel over it as high as the task lifts.
fn check_place(
    goal: &Goal,
    now: &Circumstances<'_>,
    [x, y, z]: [f64; 3],
    yaw_rad: f64,
    index: usize,
) -> Result<(), Reason> {
    let (side, width_m) = (goal.side(), goal.request().width_m);
    let hand = now.robot.hand(side);
    let workspace = Workspace::TWO_HAND_ARM;
    let (left, right) = (side == Side::Left, workspace.right_y_m);
    let y_m = if left { [-right[1], -right[0]] } else { right };
    let travel_m = goal.travel_height_m();
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
    // The hand comes open by the clearance on each side.
    let [least_m, most_m] = workspace.opening_m;
    let widest_m = most_m - 2.0 * now.settings.motion.clearance_m;
    reach(width_m, [least_m, widest_m], WIDTH)?;
    for height_m in [z, travel_m] {
        let centre_m = Vector3::new(x, y, height_m);
        let yaw_rad = hand.closing_yaw_rad(&centre_m, yaw_rad);
        let frame = GraspFrame::from_above(centre_m, yaw_rad, width_m);
        if let Err(error) = hand.posture_for(&frame) {
            let error_m = error.best.tip_error_m;
            return Err(Reason::limit(Cause::UNREACHABLE, error_m, 0.0).about(index));
        }
    }
    Ok(())
}
