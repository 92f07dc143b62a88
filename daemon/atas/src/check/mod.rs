//! Goal check: rejects a goal before anything moves.
//!
//! Inputs: client request and [`Circumstances`]. Output: a [`Goal`] or the [`Reason`] for its
//! rejection.

mod circumstances;
mod clearance;
mod fields;

pub use circumstances::Circumstances;
pub use clearance::CLEARANCE_M;

use crate::follow::{FollowSpace, across_the_middle};
use crate::goal::Goal;
use crate::kinematics::frame_of;
use crate::planning::{FREED_BY_M, OVER_TOP_M, descent_m};
use clearance::check_paths;
use core::f64::consts::{PI, TAU};
use fields::{FROM_X, FROM_YAW, HELPER_WIDTH, HOLD, LIFT, MAX_FORCE, TO_X, TO_YAW, TOP, WIDTH};
use nalgebra::Vector3;
use robot_model::{GraspFrame, HandModel, RobotVector, Side, Unreachable};
use shm_schemas::{Cause, GoalRequest, Reason};

/// Maximum lift height, m, and hold time, s, of a goal (design choice).
const LIFT_MAX_M: f64 = 0.15;
const HOLD_MAX_S: f64 = 3600.0;
/// Maximum height of an object above its grasp, m (design choice: covers every graspable object).
const TOP_MAX_M: f64 = 0.5;

/// Validates a goal in the order codes, values, sensors, reach, paths. Takes milliseconds, so call
/// it outside the tick.
///
/// # Errors
/// [`Reason`] for the rejection.
pub fn check(request: &GoalRequest, now: &Circumstances<'_>) -> Result<Goal, Reason> {
    let goal = Goal::resolve(request, now.tasks)?;
    if let Some(index) = request.values().iter().position(|v| !v.is_finite()) {
        return Err(Reason::of(Cause::NOT_FINITE).about(index));
    }
    let hands = Side::BOTH.map(|side| (side, side == goal.side() || goal.demands().both_hands));
    for (side, takes_part) in hands {
        if takes_part && !now.robot.hand(side).is_present() {
            return Err(Reason::of(Cause::NO_HAND).about(side.index()));
        }
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
        check_range(request.top_m, (0.0, TOP_MAX_M), TOP)?;
        check_force(request.max_force_n, now)?;
        check_reach(&goal, now)?;
    }
    if goal.demands().both_hands {
        let helper = now.robot.hand(Side::BOTH[1 - goal.side().index()]);
        check_range(request.helper_width_m, openings_m(helper), HELPER_WIDTH)?;
    }
    if goal.demands().turns && !now.robot.hand(goal.side()).abilities().turns_caps {
        return Err(Reason::of(Cause::CANNOT_TURN).about(goal.side().index()));
    }
    // Arm positions are unknown before the first command. The tick rejects goals until then.
    if let Some(q_rad) = now.commanded_rad {
        if request.kind.is_stream() {
            check_sides(&goal, now, q_rad)?;
        }
        let spare_m = check_paths(&goal, now, q_rad)?;
        return Ok(goal.with_spare(spare_m));
    }
    Ok(goal)
}

/// Checks the workspaces of teleoperated hands, because targets are not known in advance. Each of
/// two arms must be on its own side of the table.
fn check_sides(goal: &Goal, now: &Circumstances<'_>, q_rad: &RobotVector) -> Result<(), Reason> {
    let beside_another = now.robot.sides().count() > 1;
    for side in now.robot.sides() {
        let (hand, q_rad) = (now.robot.hand(side), now.hand_rad(q_rad, side));
        let across = across_the_middle(hand, &q_rad).filter(|_| beside_another);
        if let Some(reason) = across {
            return Err(reason);
        }
        if side != goal.side() && !goal.demands().both_hands {
            continue;
        }
        let space = FollowSpace::of(now.robot, side);
        let space = space.ok_or(Reason::of(Cause::NO_WORKSPACE).about(side.index()))?;
        let [_, [least_m, most_m], _] = space.centre_m;
        let y_m = frame_of(hand, &hand.forward(&q_rad)).centre_m.y;
        if beside_another && !(least_m..=most_m).contains(&y_m) {
            let (inner_m, y_m) = (least_m.abs().min(most_m.abs()), y_m.abs());
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

/// Checks the force limit of the goal against the minimum sensed and maximum grip force.
fn check_force(max_force_n: f64, now: &Circumstances<'_>) -> Result<(), Reason> {
    let grasp = &now.settings.grasp;
    if max_force_n == 0.0 {
        return Ok(());
    }
    check_range(max_force_n, (grasp.keep_n, grasp.f2_max_n), MAX_FORCE)
}

/// Returns the permitted range of hand openings, m.
fn openings_m(hand: &HandModel) -> (f64, f64) {
    let bounds_m = hand
        .workspace()
        .map_or([0.0, f64::MAX], |workspace| workspace.opening_m);
    bounds_m.into()
}

/// Checks workspace and arm posture for every place of the task.
fn check_reach(goal: &Goal, now: &Circumstances<'_>) -> Result<(), Reason> {
    let request = goal.request();
    if goal.demands().visits_source {
        check_place(
            goal,
            now,
            (request.from_m, FROM_X),
            (request.from_yaw_rad, FROM_YAW),
        )?;
    }
    if goal.demands().visits_target {
        check_place(
            goal,
            now,
            (request.to_m, TO_X),
            (request.to_yaw_rad, TO_YAW),
        )?;
    }
    Ok(())
}

/// Tolerance of a workspace bound, m (design choice: half the command resolution; absorbs rounding
/// errors of decimal sums).
const EDGE_M: f64 = 1e-6;

/// Checks that the hand can reach a place and travel above it at lift height.
fn check_place(
    goal: &Goal,
    now: &Circumstances<'_>,
    ([x, y, z], index): ([f64; 3], usize),
    (told_rad, yaw_index): (f64, usize),
) -> Result<(), Reason> {
    let (side, width_m) = (goal.side(), goal.request().width_m);
    let hand = now.robot.hand(side);
    let travel_m = goal.travel_height_m();
    let reach = |value: f64, [lower, upper]: [f64; 2], index: usize| {
        if value >= lower - EDGE_M && value <= upper + EDGE_M {
            return Ok(());
        }
        check_range(value, (lower, upper), index).map_err(|r| Reason {
            cause: Cause::UNREACHABLE,
            ..r
        })
    };
    // The hand arrives open by the clearance on each side and departs wider.
    let wide_m = 2.0 * now.settings.motion.clearance_m;
    let widest_m = hand.widest_m().max(width_m);
    let mut open_m = (width_m + wide_m).min(widest_m);
    let freed_m = (width_m + 2.0 * FREED_BY_M).min(widest_m);
    if let Some(workspace) = hand.workspace() {
        reach(x, workspace.x_m, index)?;
        reach(y, workspace.y_m, index + 1)?;
        reach(z, workspace.z_m, index + 2)?;
        reach(travel_m, workspace.z_m, LIFT)?;
        let [least_m, most_m] = workspace.opening_m;
        reach(width_m, [least_m, most_m - wide_m], WIDTH)?;
        // The workspace guarantees a posture for every opening.
        open_m = width_m;
    }
    let frame = |height_m: f64, opening_m: f64, yaw_rad: f64| {
        let centre_m = Vector3::new(x, y, height_m);
        let yaw_rad = hand.closing_yaw_rad(&centre_m, yaw_rad);
        GraspFrame::from_above(centre_m, yaw_rad, opening_m)
    };
    let goes = |yaw_rad: f64| {
        let grasp = hand.posture_for(&frame(z, open_m, yaw_rad))?;
        hand.posture_for(&frame(travel_m, open_m, yaw_rad))?;
        // Only a hand that tilts to open can lack a posture when open but not when closed.
        if hand.domes_tilt() {
            hand.posture_for(&frame(z, freed_m, yaw_rad))?;
            hand.posture_for(&frame(travel_m, freed_m, yaw_rad))?;
        }
        hand.touching_posture_for(&frame(z, width_m, yaw_rad))?;
        Ok(grasp)
    };
    let grasp = goes(told_rad).map_err(|error| {
        let nearest_rad = nearest_yaw_rad(told_rad, |yaw_rad| goes(yaw_rad).is_ok());
        nearest_rad.map_or_else(
            || why_unreachable(&error).about(index),
            |nearest_rad| Reason::limit(Cause::UNREACHABLE, told_rad, nearest_rad).about(yaw_index),
        )
    })?;
    let top_m = goal.request().top_m;
    if top_m > 0.0 {
        // The object must fit below the palm, and the hand must approach from above it.
        let room_m = hand.lowest_of_palm_m(&hand.forward(&grasp.q_rad)) - z - OVER_TOP_M;
        check_range(top_m, (0.0, room_m), TOP)?;
        let over_m = z + descent_m(hand, goal.request(), now.settings);
        let over = hand.posture_for(&frame(over_m, open_m, told_rad));
        over.map_err(|error| why_unreachable(&error).about(TOP))?;
    }
    Ok(())
}

/// Step, rad, and number of steps of the search for a feasible yaw (design choice: covers ±90°,
/// enough because the grasp sides are interchangeable).
const TURN_STEP_RAD: f64 = PI / 36.0;
const TURN_STEPS: usize = 18;

/// Returns the feasible yaw closest to the commanded one, rad.
fn nearest_yaw_rad(told_rad: f64, takes: impl Fn(f64) -> bool) -> Option<f64> {
    let turns_rad = (1..=TURN_STEPS).map(|step| step as f64 * TURN_STEP_RAD);
    let mut yaws_rad = turns_rad.flat_map(|by_rad| [told_rad + by_rad, told_rad - by_rad]);
    yaws_rad.find(|yaw_rad| takes(*yaw_rad))
}

/// Returns the reason why a place is unreachable: fingertip orientation or position.
fn why_unreachable(error: &Unreachable) -> Reason {
    let best = &error.best;
    if best.meets_tips() {
        let (askew_rad, bears_rad) = (best.dome_error_rad, error.dome_error_max_rad);
        return Reason::limit(Cause::DOMES_ASKEW, askew_rad, bears_rad);
    }
    let error_m = best.tip_error_m.max(best.spread_error_m);
    Reason::limit(Cause::UNREACHABLE, error_m, 0.0)
}
