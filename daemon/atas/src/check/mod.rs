//! Goal check: rejects a goal before anything moves.
//!
//! Inputs: client request and [`GoalContext`]. Output: a [`Goal`] or the [`Reason`] for its
//! rejection.

mod clearance;
mod context;

pub use clearance::CLEARANCE_M;
pub use context::GoalContext;

use crate::goal::Goal;
use crate::kinematics::grasp_pose;
use crate::planning::{RELEASED_BY_M, TOP_CLEARANCE_M, approach_height_m};
use crate::teleop::{TeleopWorkspace, arm_across_middle};
use clearance::check_paths;
use core::f64::consts::{PI, TAU};
use nalgebra::Vector3;
use robot_model::{GraspPose, HandModel, HandSide, RobotVector, Unreachable};
use shm_schemas::{GoalField, GoalRequest, Hand, Reason};

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
pub fn check(request: &GoalRequest, now: &GoalContext<'_>) -> Result<Goal, Reason> {
    let goal = Goal::resolve(request, now.tasks)?;
    if let Some(index) = request.values().iter().position(|v| !v.is_finite()) {
        let field = GoalField(index as u32);
        return Err(Reason::NotFinite { field });
    }
    let hands =
        HandSide::BOTH.map(|side| (side, side == goal.side() || goal.requirements().both_hands));
    for (side, takes_part) in hands {
        let hand = Hand::BOTH[side.index()];
        if takes_part && !now.robot.hand(side).is_present() {
            return Err(Reason::NoHand { hand });
        }
        if takes_part && !now.wiring.hands[side.index()].required {
            return Err(Reason::NoSensor { hand });
        }
    }
    let visits = goal.requirements().visits_source || goal.requirements().visits_target;
    if visits || goal.requirements().both_hands {
        check_range(request.from_yaw_rad, (-TAU, TAU), GoalField::FROM_YAW)?;
        check_range(request.to_yaw_rad, (-TAU, TAU), GoalField::TO_YAW)?;
        check_range(request.lift_m, (0.0, LIFT_MAX_M), GoalField::LIFT)?;
        check_range(request.hold_s, (0.0, HOLD_MAX_S), GoalField::HOLD)?;
        check_range(request.top_m, (0.0, TOP_MAX_M), GoalField::TOP)?;
        check_force(request.max_force_n, now)?;
        check_reach(&goal, now)?;
    }
    if goal.requirements().both_hands {
        let helper = now.robot.hand(HandSide::BOTH[1 - goal.side().index()]);
        check_range(
            request.helper_width_m,
            opening_range_m(helper),
            GoalField::HELPER_WIDTH,
        )?;
    }
    if goal.requirements().turns && !now.robot.hand(goal.side()).capabilities().cap_turning {
        let hand = Hand::BOTH[goal.side().index()];
        return Err(Reason::CannotTurn { hand });
    }
    // Arm positions are unknown before the first command. The tick rejects goals until then.
    if let Some(q) = now.commanded_position {
        if request.kind.is_stream() {
            check_sides(&goal, now, q)?;
        }
        let clearance_margin_m = check_paths(&goal, now, q)?;
        return Ok(goal.with_clearance_margin(clearance_margin_m));
    }
    Ok(goal)
}

/// Checks the workspaces of teleoperated hands, because targets are not known in advance. Each of
/// two arms must be on its own side of the table.
fn check_sides(goal: &Goal, now: &GoalContext<'_>, q: &RobotVector) -> Result<(), Reason> {
    let beside_another = now.robot.sides().count() > 1;
    for side in now.robot.sides() {
        let (hand, q) = (now.robot.hand(side), now.hand_position(q, side));
        let across = arm_across_middle(hand, &q).filter(|_| beside_another);
        if let Some(reason) = across {
            return Err(reason);
        }
        if side != goal.side() && !goal.requirements().both_hands {
            continue;
        }
        let space = TeleopWorkspace::new(now.robot, side);
        let acting = Hand::BOTH[side.index()];
        let space = space.ok_or(Reason::NoWorkspace { hand: acting })?;
        let [_, [least_m, most_m], _] = space.centre_m;
        let y_m = grasp_pose(hand, &hand.forward(&q)).centre_m.y;
        if beside_another && !(least_m..=most_m).contains(&y_m) {
            let (inner_m, y_m) = (least_m.abs().min(most_m.abs()), y_m.abs());
            return Err(Reason::AcrossTheMiddle {
                hand: acting,
                gap_m: y_m,
                limit_m: inner_m,
            });
        }
    }
    Ok(())
}

fn check_range(value: f64, (lower, upper): (f64, f64), field: GoalField) -> Result<(), Reason> {
    if value >= lower && value <= upper {
        return Ok(());
    }
    let limit = nearer_bound(value, lower, upper);
    Err(Reason::OutOfRange {
        field,
        value,
        limit,
    })
}

/// Returns the bound that a value outside the range violates.
fn nearer_bound(value: f64, lower: f64, upper: f64) -> f64 {
    if value < lower { lower } else { upper }
}

/// Checks the force limit of the goal against the minimum sensed and maximum grip force.
fn check_force(max_force_n: f64, now: &GoalContext<'_>) -> Result<(), Reason> {
    let grasp = &now.settings.grasp;
    if max_force_n == 0.0 {
        return Ok(());
    }
    check_range(
        max_force_n,
        (grasp.carry_min_n, grasp.f2_max_n),
        GoalField::MAX_FORCE,
    )
}

/// Returns the permitted range of hand openings, m.
fn opening_range_m(hand: &HandModel) -> (f64, f64) {
    let bounds_m = hand
        .workspace()
        .map_or([0.0, f64::MAX], |workspace| workspace.opening_m);
    bounds_m.into()
}

/// Checks workspace and arm posture for every place of the task.
fn check_reach(goal: &Goal, now: &GoalContext<'_>) -> Result<(), Reason> {
    let request = goal.request();
    if goal.requirements().visits_source {
        check_place(
            goal,
            now,
            (request.from_m, GoalField::FROM_X),
            (request.from_yaw_rad, GoalField::FROM_YAW),
        )?;
    }
    if goal.requirements().visits_target {
        check_place(
            goal,
            now,
            (request.to_m, GoalField::TO_X),
            (request.to_yaw_rad, GoalField::TO_YAW),
        )?;
    }
    Ok(())
}

/// Tolerance of a workspace bound, m (design choice: half the command resolution; absorbs rounding
/// errors of decimal sums).
const BOUND_TOLERANCE_M: f64 = 1e-6;

/// Checks that the hand can reach a place and travel above it at lift height.
fn check_place(
    goal: &Goal,
    now: &GoalContext<'_>,
    ([x, y, z], place): ([f64; 3], GoalField),
    (yaw_rad, yaw): (f64, GoalField),
) -> Result<(), Reason> {
    let (side, width_m) = (goal.side(), goal.request().width_m);
    let hand = now.robot.hand(side);
    let travel_m = goal.travel_height_m();
    let reach = |value: f64, [lower, upper]: [f64; 2], field: GoalField| {
        if value >= lower - BOUND_TOLERANCE_M && value <= upper + BOUND_TOLERANCE_M {
            return Ok(());
        }
        let limit = nearer_bound(value, lower, upper);
        Err(Reason::Unreachable {
            field,
            value,
            limit,
        })
    };
    // The hand arrives open by the clearance on each side and departs wider.
    let wide_m = 2.0 * now.settings.motion.clearance_m;
    let widest_m = hand.max_opening_m().max(width_m);
    let mut open_m = (width_m + wide_m).min(widest_m);
    let freed_m = (width_m + 2.0 * RELEASED_BY_M).min(widest_m);
    if let Some(workspace) = hand.workspace() {
        let [of_x, of_y, of_z] = [0, 1, 2].map(|axis| GoalField(place.0 + axis));
        reach(x, workspace.x_m, of_x)?;
        reach(y, workspace.y_m, of_y)?;
        reach(z, workspace.z_m, of_z)?;
        reach(travel_m, workspace.z_m, GoalField::LIFT)?;
        let [least_m, most_m] = workspace.opening_m;
        reach(width_m, [least_m, most_m - wide_m], GoalField::WIDTH)?;
        // The workspace guarantees a posture for every opening.
        open_m = width_m;
    }
    let frame = |height_m: f64, opening_m: f64, yaw_rad: f64| {
        let centre_m = Vector3::new(x, y, height_m);
        let yaw_rad = hand.closing_yaw_rad(&centre_m, yaw_rad);
        GraspPose::from_above(centre_m, yaw_rad, opening_m)
    };
    let goes = |yaw_rad: f64| {
        let grasp = hand.posture_for(&frame(z, open_m, yaw_rad))?;
        hand.posture_for(&frame(travel_m, open_m, yaw_rad))?;
        // Only a hand that tilts to open can lack a posture when open but not when closed.
        if hand.domes_tilt() {
            hand.posture_for(&frame(z, freed_m, yaw_rad))?;
            hand.posture_for(&frame(travel_m, freed_m, yaw_rad))?;
        }
        hand.contact_posture_for(&frame(z, width_m, yaw_rad))?;
        Ok(grasp)
    };
    let grasp = goes(yaw_rad).map_err(|error| {
        let nearest_rad = nearest_yaw_rad(yaw_rad, |yaw_rad| goes(yaw_rad).is_ok());
        nearest_rad.map_or_else(
            || unreachable_reason(&error, place),
            |nearest_rad| Reason::Unreachable {
                field: yaw,
                value: yaw_rad,
                limit: nearest_rad,
            },
        )
    })?;
    let top_m = goal.request().top_m;
    if top_m > 0.0 {
        // The object must fit below the palm, and the hand must approach from above it.
        let room_m = hand.lowest_of_palm_m(&hand.forward(&grasp.q)) - z - TOP_CLEARANCE_M;
        check_range(top_m, (0.0, room_m), GoalField::TOP)?;
        let over_m = z + approach_height_m(hand, goal.request(), now.settings);
        let over = hand.posture_for(&frame(over_m, open_m, yaw_rad));
        over.map_err(|error| unreachable_reason(&error, GoalField::TOP))?;
    }
    Ok(())
}

/// Step, rad, and number of steps of the search for a feasible yaw (design choice: covers ±90°,
/// enough because the grasp sides are interchangeable).
const YAW_STEP_RAD: f64 = PI / 36.0;
const YAW_STEPS: usize = 18;

/// Returns the feasible yaw closest to the commanded one, rad.
fn nearest_yaw_rad(yaw_rad: f64, is_feasible: impl Fn(f64) -> bool) -> Option<f64> {
    let turns_rad = (1..=YAW_STEPS).map(|step| step as f64 * YAW_STEP_RAD);
    let mut yaws_rad = turns_rad.flat_map(|by_rad| [yaw_rad + by_rad, yaw_rad - by_rad]);
    yaws_rad.find(|yaw_rad| is_feasible(*yaw_rad))
}

/// Returns the reason why a place is unreachable: fingertip orientation or position.
fn unreachable_reason(error: &Unreachable, place: GoalField) -> Reason {
    let best = &error.best;
    if best.meets_tips() {
        return Reason::FingertipsMisaligned {
            place,
            error_rad: best.dome_error_rad,
            limit_rad: error.dome_error_max_rad,
        };
    }
    Reason::NoPosture {
        place,
        error_m: best.tip_error_m.max(best.spread_error_m),
    }
}
