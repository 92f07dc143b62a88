//! `atas robot`: model, workspace and capabilities of a robot.
//!
//! ```text
//!  name or robot file ─▶ RobotFiles ─▶ RobotModel ─┬─ list ──▶ one line per built-in robot
//!                                                  └─ check ─▶ joints, workspace, tasks; picture
//! ```
//!
//! * **Invariants:** the loader reports all errors of a file at once. Inverse kinematics determines
//!   the capabilities of a hand; tasks are supported by the criteria of `demo` and `eval`. `check`
//!   promises a task only after it succeeded once in simulation.

mod facing;
mod reach;

use robot_model::{
    GraspSide, HandModel, HandSide, Joint, JointKind, RobotFiles, RobotModel, SHIPPED,
};
use std::path::Path;
use std::time::Instant;

use atas_console::arguments::RobotAction;
use atas_console::{Exit, ExitError, Output, number, table};
use atas_evaluation::drawing::robot_views;
use atas_evaluation::{NominalTrial, Task};
use serde_json::{Value, json};

use crate::picture;
use facing::Facing;
use reach::Reach;

/// Smallest cosine between a fingertip axis and the direction to the opposite grasp side (design
/// choice: 60°).
const FACES_COS: f64 = 0.5;

pub(crate) fn robot(action: &RobotAction, output: &mut Output) -> anyhow::Result<()> {
    match action {
        RobotAction::List => list(output),
        RobotAction::Check { robot, out } => check(robot, out.as_deref(), output),
    }
}

fn list(output: &mut Output) -> anyhow::Result<()> {
    let mut rows = table(&["robot", "joints", "fingertips", "tasks"]);
    let mut robots = Vec::new();
    for files in SHIPPED {
        let robot = files.load()?;
        let (joints, fingertip_count, tasks) =
            (robot.joint_count(), fingertip_count(&robot), tasks(&robot));
        rows.add_row([
            files.name.to_string(),
            joints.to_string(),
            fingertip_count.to_string(),
            tasks.join(", "),
        ]);
        robots.push(
            json!({ "name": files.name, "joints": joints, "fingers": fingertip_count, "tasks": tasks }),
        );
    }
    if output.is_json() {
        return output.json(&json!({ "robots": robots }));
    }
    output.table(rows)
}

fn check(name: &str, out: Option<&Path>, output: &mut Output) -> anyhow::Result<()> {
    let unusable =
        |error: robot_model::ModelError| ExitError::with_code(Exit::Usage, error.to_string());
    let files = RobotFiles::find(name).map_err(unusable)?;
    let robot = files.load().map_err(unusable)?;
    let mut remarks = files.remarks().map_err(unusable)?;
    if let Some(out) = out {
        let (drawn, not_drawn) = robot_views(&files, &robot).map_err(unusable)?;
        picture::write(out, &drawn.svg(&files.name))?;
        remarks.extend(not_drawn);
    }
    let begin = Instant::now();
    let trials = NominalTrial::run_all(&robot)?;
    let tried_s = begin.elapsed().as_secs_f64();
    let done = |task: Task| trials.iter().any(|trial| trial.task == task && trial.done);
    let (can, cannot): (Vec<Task>, Vec<Task>) = Task::ALL.into_iter().partition(|task| done(*task));
    let names = |tasks: Vec<Task>| tasks.into_iter().map(Task::name).collect::<Vec<_>>();
    if output.is_json() {
        let hands = robot.sides().map(|side| robot.hand(side));
        let hands: Vec<Value> = hands.map(hand_json).collect();
        return output.json(&json!({
            "name": files.name,
            "joints": robot.joint_count(),
            "fingers": fingertip_count(&robot),
            "tasks": names(can),
            "trials": trials.iter().map(trial_json).collect::<Vec<_>>(),
            "hands": hands,
            "remarks": remarks,
        }));
    }
    output.line(format_args!(
        "{}: {} joints, {} fingertips",
        files.name,
        robot.joint_count(),
        fingertip_count(&robot)
    ))?;
    for side in robot.sides() {
        print_hand(robot.hand(side), output)?;
    }
    for remark in remarks {
        output.line(remark)?;
    }
    output.line(format_args!(
        "\neach task that the kinematics allow, tried once in simulation ({} s):",
        number(tried_s, 1)
    ))?;
    for trial in &trials {
        output.line(trial_text(trial))?;
    }
    let can = match names(can) {
        none if none.is_empty() => "no task".to_owned(),
        names => names.join(", "),
    };
    output.line(format_args!("can do: {can}"))?;
    if !cannot.is_empty() {
        output.line(format_args!("cannot do: {}", names(cannot).join(", ")))?;
    }
    match out {
        Some(out) => output.line(format_args!("wrote {}", out.display())),
        None => Ok(()),
    }
}

/// Formats a trial: `screw with cap (30 mm): refused: obstructed; reason`.
fn trial_text(trial: &NominalTrial) -> String {
    let NominalTrial {
        task,
        object,
        outcome,
        ..
    } = trial;
    let width_mm = number(trial.width_m * 1e3, 0);
    let mut text = format!("  {} with {object} ({width_mm} mm): {outcome}", task.name());
    if trial.done {
        return text;
    }
    if let Some(reason) = &trial.reason {
        text.push_str("; ");
        text.push_str(reason);
    }
    if trial.rests_below_object() {
        let mm = |height_m: f64| number(height_m * 1e3, 0);
        text.push_str(&format!(
            "\n    at rest the fingertips are {} mm above the table, the object is {} mm high: \
             raise the rest pose (`rest_deg`, `rest_m` or `home_m`)",
            mm(trial.rest_height_m),
            mm(trial.object_top_m)
        ));
    }
    text
}

fn trial_json(trial: &NominalTrial) -> Value {
    json!({
        "task": trial.task.name(),
        "object": trial.object,
        "width_m": trial.width_m,
        "done": trial.done,
        "outcome": trial.outcome,
        "reason": trial.reason,
        "object_top_m": trial.object_top_m,
        "rest_height_m": trial.rest_height_m,
        "simulated_s": trial.simulated_s,
    })
}

fn fingertip_count(robot: &RobotModel) -> usize {
    robot
        .sides()
        .map(|side| robot.hand(side).fingertip_count())
        .sum()
}

fn tasks(robot: &RobotModel) -> Vec<&'static str> {
    let within = Task::ALL
        .into_iter()
        .filter(|task| task.is_supported_by(robot));
    within.map(Task::name).collect()
}

fn print_hand(hand: &HandModel, output: &mut Output) -> anyhow::Result<()> {
    let name = side_name(hand);
    output.line(format_args!("\n{name} hand"))?;
    let mut rows = table(&[
        "joint",
        "moves",
        "from",
        "to",
        "rest",
        "speed per s",
        "stiffness",
    ]);
    for (index, joint) in hand.joints().iter().enumerate() {
        let shown = |value: f64| format_position(joint, value);
        rows.add_row([
            joint.name.to_string(),
            moves(hand, index),
            shown(joint.lower),
            shown(joint.upper),
            shown(hand.reference()[index]),
            shown(joint.velocity_max),
            number(joint.stiffness, 0),
        ]);
    }
    output.table(rows)?;
    for (finger, link) in hand.tip_links().enumerate() {
        let (side, radius_mm) = (
            hand.grasp_side(finger).index() + 1,
            hand.tip_radius_m()[finger] * 1e3,
        );
        let layout = hand.skin().layout;
        output.line(format_args!(
            "fingertip {link}: grasp side {side}, {layout}, contact surface {radius_mm:.1} mm from \
             the frame origin"
        ))?;
    }
    for link in misaligned_fingertips(hand) {
        output.line(format_args!(
            "fingertip {link} does not face the opposite grasp side in the rest pose: set \
             `facing`, or correct `side` or `rest_deg`"
        ))?;
    }
    for (side, apart_m) in fingertip_spread_m(hand) {
        let apart_mm = apart_m * 1e3;
        output.line(format_args!(
            "fingertips of grasp side {} are {apart_mm:.0} mm apart: their edges touch objects \
             that are narrower than that",
            side.index() + 1
        ))?;
    }
    for line in Facing::from_hand(hand).lines() {
        output.line(line)?;
    }
    let home_m = hand.home_m();
    output.line(format_args!(
        "rest pose: {:.3},{:.3},{:.3} m, opening {:.0} mm, closing axis {:.0}°",
        home_m.x,
        home_m.y,
        home_m.z,
        hand.home_opening_m() * 1e3,
        hand.home_yaw_rad().to_degrees()
    ))?;
    print_reach(hand, output)?;
    let able = hand.capabilities();
    let turn = if able.cap_turning_by_wrist {
        "turn a cap with the wrist"
    } else {
        "turn a cap with the fingertips"
    };
    let words = [
        (able.lift, "lift"),
        (able.carry, "carry sideways"),
        (able.cap_turning, turn),
        (able.side_grasp, "grasp at an angle from the side"),
    ];
    for (can, what) in words {
        output.line(format_args!(
            "{} {what}",
            if can { "can" } else { "cannot" }
        ))?;
    }
    Ok(())
}

/// Prints the workspace of the robot file, or the one found by inverse kinematics.
fn print_reach(hand: &HandModel, output: &mut Output) -> anyhow::Result<()> {
    if let Some(space) = hand.workspace() {
        let space = reach::workspace_entry(space);
        return output.line(format_args!("workspace in the robot file: {space}"));
    }
    match Reach::from_hand(hand) {
        Some(reach) => output.line(format_args!(
            "reachable with this closing axis, on a grid of {:.0} mm; entry for the robot file:\n  \
             workspace = {}",
            reach::STEP_M * 1e3,
            reach::workspace_entry(&reach.space)
        )),
        None => output.line(format_args!(
            "no reachable pose around the rest pose: {}; see `rest_deg`, `down` and `home_m`",
            reach::unreachable_reason(hand)
        )),
    }
}

/// Returns grasp sides with several fingertips, each with the largest distance between two of them
/// in the reference posture, m.
fn fingertip_spread_m(hand: &HandModel) -> Vec<(GraspSide, f64)> {
    let pose = hand.forward(hand.reference());
    let apart_m = |side: GraspSide| {
        let tips = || hand.fingertips_of(side).map(|finger| pose.tip_m(finger));
        let pairs = tips().flat_map(|a| tips().map(move |b| (a - b).norm()));
        pairs.fold(0.0_f64, f64::max)
    };
    GraspSide::BOTH
        .into_iter()
        .filter(|side| hand.fingertips_of(*side).count() > 1)
        .map(|side| (side, apart_m(side)))
        .collect()
}

/// Returns fingertips that do not face the opposite grasp side in the reference posture; such a
/// hand cannot hold an object.
fn misaligned_fingertips(hand: &HandModel) -> Vec<&str> {
    let pose = hand.forward(hand.reference());
    let faces = |finger: usize| {
        let across =
            pose.side_m(hand.grasp_side(finger).opposite()) - pose.side_m(hand.grasp_side(finger));
        // A NaN counts as not facing.
        across
            .try_normalize(1e-9)
            .is_some_and(|across| pose.dome_axis(finger).dot(&across) > FACES_COS)
    };
    let links = hand.tip_links().enumerate();
    links
        .filter(|(finger, _)| !faces(*finger))
        .map(|(_, link)| link)
        .collect()
}

fn hand_json(hand: &HandModel) -> Value {
    let joint = |(index, joint): (usize, &Joint)| {
        json!({
            "name": joint.name.as_str(),
            "slides": joint.kind == JointKind::Prismatic,
            "arm": hand.arm_joints().contains(&index),
            "lower": joint.lower,
            "upper": joint.upper,
            "rest": hand.reference()[index],
            "velocity": joint.velocity_max,
            "stiffness": joint.stiffness,
        })
    };
    let tip = |(finger, link): (usize, &str)| {
        json!({
            "link": link,
            "side": hand.grasp_side(finger).index() + 1,
            "radius_m": hand.tip_radius_m()[finger],
        })
    };
    let space = hand
        .workspace()
        .copied()
        .or_else(|| Reach::from_hand(hand).map(|reach| reach.space));
    let able = hand.capabilities();
    json!({
        "side": side_name(hand),
        "skin": {
            "layout": hand.skin().layout.to_string(),
            "compression_m": hand.skin().compression.at_1n_m,
            "exponent": hand.skin().compression.exponent,
        },
        "joints": hand.joints().iter().enumerate().map(joint).collect::<Vec<_>>(),
        "fingertips": hand.tip_links().enumerate().map(tip).collect::<Vec<_>>(),
        "home_m": hand.home_m().as_slice(),
        "home_opening_m": hand.home_opening_m(),
        "workspace": space.map(|space| json!({
            "x_m": space.x_m, "y_m": space.y_m, "z_m": space.z_m, "opening_m": space.opening_m,
        })),
        "turned_away": misaligned_fingertips(hand),
        "facing": Facing::from_hand(hand).json(),
        "capabilities": { "lift": able.lift, "carry": able.carry, "cap_turning": able.cap_turning, "cap_turning_by_wrist": able.cap_turning_by_wrist },
    })
}

fn side_name(hand: &HandModel) -> &'static str {
    match hand.side() {
        HandSide::Left => "left",
        HandSide::Right => "right",
    }
}

/// Returns the fingertips that a joint moves, or "hand" for an arm joint.
fn moves(hand: &HandModel, joint: usize) -> String {
    if hand.arm_joints().contains(&joint) {
        return "hand".into();
    }
    let moved = (0..hand.fingertip_count())
        .filter(|finger| hand.movers(*finger).any(|mover| mover.joint == joint))
        .map(|finger| (finger + 1).to_string());
    format!("tip {}", moved.collect::<Vec<_>>().join(", "))
}

/// Formats a joint position in mm or degrees.
fn format_position(joint: &Joint, value: f64) -> String {
    match joint.kind {
        JointKind::Prismatic => format!("{} mm", number(value * 1e3, 1)),
        JointKind::Revolute => format!("{}°", number(value.to_degrees(), 1)),
    }
}
