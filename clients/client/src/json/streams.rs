//! Payloads of the streams as JSON, for `atas topic echo`.

use serde_json::{Value, json};
use shm_schemas::{
    AgentSensors, AgentTruth, ArenaTruth, BaseCommand, BaseState, FieldTruth, FingerReport,
    HandFrame, HandReport, JointState, ObjectTruth, PostTruth, RunHeader, SensorStatus, Stamp,
    TickReport, TrialTruth, View, WallTruth, WheelCommands, WorldTruth,
};

use super::{age_ns, names};

/// Adds the stamp, which every payload has.
fn stamped(stamp: &Stamp, mut value: Value) -> Value {
    value["sequence"] = stamp.sequence.into();
    value["captured_ns"] = stamp.captured_ns.into();
    value["writer_epoch"] = format!("{:016x}", stamp.writer_epoch).into();
    value
}

/// Returns a tick report.
#[must_use]
pub fn report(report: &TickReport) -> Value {
    let stages = TickReport::STAGE_NAMES.iter().zip(report.stage_ns);
    let stages: serde_json::Map<String, Value> = stages
        .map(|(name, ns)| ((*name).to_owned(), ns.into()))
        .collect();
    let value = json!({
        "tick": report.tick,
        "missed_ticks": report.missed_ticks,
        "goal_id": report.goal_id,
        "mode": report.mode.name(),
        "joint_sequence": report.joint_sequence,
        "wake_late_ns": report.wake_late_ns,
        "stage_ns": stages,
        "sensor_to_command_ns": report.sensor_to_command_ns,
        "hands": report.hands.iter().map(hand).collect::<Vec<_>>(),
    });
    stamped(&report.stamp, value)
}

fn hand(hand: &HandReport) -> Value {
    json!({
        "frame_sequence": hand.frame_sequence,
        "frame_age_ns": age_ns(hand.frame_age_ns),
        "frames": hand.frames,
        "modules": names(hand.modules_active),
        "step": hand.step,
        "f1_n": hand.f1_n,
        "f2_n": hand.f2_n,
        "stiffness_n_m": hand.stiffness_n_m,
        "centre_m": hand.centre_m,
        "fingers": hand.fingers.iter().map(finger).collect::<Vec<_>>(),
    })
}

fn finger(finger: &FingerReport) -> Value {
    json!({
        "normal_n": finger.normal_n,
        "tangential_n": finger.tangential_n,
        "tangential_increment_n": finger.tangential_increment_n,
        "utilisation": finger.utilisation,
        "utilisation_now": finger.utilisation_now,
        "friction": finger.friction,
        "closing_m_s": finger.closing_m_s,
        "in_contact": finger.in_contact != 0,
    })
}

/// Returns the newest frames and joints; `null` for data that have not arrived.
#[must_use]
pub fn view(view: &View) -> Value {
    let frames = view.frames.iter().zip(view.has_frame);
    let frames = frames.map(|(f, has)| if has != 0 { frame(f) } else { Value::Null });
    let value = json!({
        "tick": view.tick,
        "frames": frames.collect::<Vec<_>>(),
        "joints": if view.has_joints != 0 { joints(&view.joints) } else { Value::Null },
    });
    stamped(&view.stamp, value)
}

fn frame(frame: &HandFrame) -> Value {
    let count =
        crate::layouts::named(frame.layout_hash).map_or(frame.force_n[0].len(), |l| l.count);
    let fingers = (frame.finger_count as usize).min(frame.force_n.len());
    let forces = frame.force_n[..fingers].iter().zip(frame.valid_mask);
    let forces = forces.map(|(force_n, valid)| {
        let elements = force_n[..count].iter().enumerate();
        let elements = elements.map(|(e, force_n)| (valid >> e & 1 == 1).then_some(force_n));
        elements.collect::<Vec<_>>()
    });
    let value = json!({
        "hand": frame.hand.name(),
        "layout_hash": format!("{:016x}", frame.layout_hash),
        "force_n": forces.collect::<Vec<_>>(),
    });
    stamped(&frame.stamp, value)
}

fn joints(joints: &JointState) -> Value {
    let count = (joints.joint_count as usize).min(joints.position.len());
    let value = json!({
        "position": joints.position[..count],
        "velocity": joints.velocity[..count],
        "effort": joints.effort[..count],
    });
    stamped(&joints.stamp, value)
}

/// Returns the status of a sensor process.
#[must_use]
pub fn sensor(status: &SensorStatus) -> Value {
    let value = json!({
        "driver": status.driver.as_str(),
        "device": status.device.as_str(),
        "hand": status.hand.name(),
        "alive": status.alive != 0,
        "frames": status.frames,
        "lost": status.lost,
        "junk_bytes": status.junk_bytes,
        "checksum_failures": status.checksum_failures,
        "device_errors": status.device_errors,
        "device_status": status.device_status,
    });
    stamped(&status.stamp, value)
}

/// Returns the run header without the parameter values.
#[must_use]
pub fn run(header: &RunHeader) -> Value {
    let value = json!({
        "version": header.version.as_str(),
        "config_hash": format!("{:016x}", header.config_hash),
        "robot": header.robot.as_str(),
        "rate_hz": header.rate_hz,
        "config": header.config.as_str(),
    });
    stamped(&header.stamp, value)
}

/// Returns the true state of the simulated world.
#[must_use]
pub fn truth(truth: &WorldTruth) -> Value {
    let objects = truth.objects.iter().take(truth.object_count as usize);
    let value = json!({
        "missed_ticks": truth.missed_ticks,
        "expired_commands": truth.expired_commands,
        "objects": objects.map(object).collect::<Vec<_>>(),
        "slip_m": truth.slip_m,
        "normal_n": truth.normal_n,
    });
    stamped(&truth.stamp, value)
}

fn object(object: &ObjectTruth) -> Value {
    json!({
        "name": object.name.as_str(),
        "position_m": object.position_m,
        "orientation": object.orientation,
        "lifted_m": object.lifted_m,
        "needed_n": object.needed_n,
        "max_force_n": object.max_force_n,
        "cap_angle_rad": object.cap_angle_rad,
        "crushed": object.crushed != 0,
        "dropped": object.dropped != 0,
    })
}

/// Returns the sensor inputs of all swarm robots.
#[must_use]
pub fn agents(sensors: &AgentSensors) -> Value {
    let count = (sensors.agent_count as usize).min(sensors.row.len());
    let value = json!({
        "frame": sensors.frame,
        "trial": sensors.trial,
        "field_hash": format!("{:016x}", sensors.field_hash),
        "row": sensors.row[..count],
    });
    stamped(&sensors.stamp, value)
}

/// Returns the wheel commands of all swarm robots.
#[must_use]
pub fn wheels(commands: &WheelCommands) -> Value {
    let count = (commands.agent_count as usize).min(commands.output.len());
    let value = json!({
        "frame": commands.frame,
        "trial": commands.trial,
        "table_hash": format!("{:016x}", commands.table_hash),
        "output": commands.output[..count],
    });
    stamped(&commands.stamp, value)
}

/// Returns the state of a mobile base.
#[must_use]
pub fn base(state: &BaseState) -> Value {
    let value = json!({
        "frame": state.frame,
        "object_m": (state.object_stands != 0).then_some(state.object_m),
        "goal_m": state.goal_m,
        "right_of_way_m": state.right_of_way_m,
        "wheels_stopped": state.wheels_stopped != 0,
        "mishap": state.mishap.name(),
    });
    stamped(&state.stamp, value)
}

/// Returns a command to a mobile base.
#[must_use]
pub fn base_command(command: &BaseCommand) -> Value {
    let value = json!({
        "frame": command.frame,
        "owner": command.owner.name(),
        "light": command.light.name(),
    });
    stamped(&command.stamp, value)
}

/// Returns the swarm fields: contents, positions, and all trials so far, oldest first.
#[must_use]
pub fn arena(arena: &ArenaTruth) -> Value {
    let agents = arena.agents.iter().take(arena.agent_count as usize);
    let fields = arena.fields.iter().take(arena.field_count as usize);
    let mut past: Vec<&TrialTruth> = arena.trials.iter().filter(|past| past.goal != 0).collect();
    past.sort_unstable_by_key(|past| past.trial);
    let walls = arena.walls.iter().take(arena.wall_count as usize);
    let wall = |wall: &WallTruth| json!({ "from_px": wall.from_px, "to_px": wall.to_px });
    let posts = arena.posts.iter().take(arena.post_count as usize);
    let post = |post: &PostTruth| json!({ "at_px": post.at_px, "radius_px": post.radius_px });
    let value = json!({
        "frame": arena.frame,
        "trial": arena.trial,
        "trial_count": arena.trial_count,
        "goal": arena.goal,
        "execution_frames": arena.execution_frames,
        "trial_frames": arena.trial_frames,
        "driven": arena.is_driven != 0,
        "team": arena.team,
        "preset": arena.preset.as_str(),
        "field_hash": format!("{:016x}", arena.field_hash),
        "table_hash": format!("{:016x}", arena.table_hash),
        "half_side_px": arena.half_side_px,
        "agent_radius_px": arena.agent_radius_px,
        "object_radius_px": arena.object_radius_px,
        "goal_radius_px": arena.goal_radius_px,
        "ir_range_px": arena.ir_range_px,
        "ir_angle_steps": arena.ir_angle_steps,
        "photo_angle_steps": arena.photo_angle_steps,
        "photo_half_angle_cosine": arena.photo_half_angle_cosine,
        "object_light_px": arena.object_light_px,
        "goal_light_px": arena.goal_light_px,
        "friction_stall_forces": (arena.friction_stall_forces > 0.0).then_some(arena.friction_stall_forces),
        "yielding": arena.yielding,
        "walls": walls.map(wall).collect::<Vec<_>>(),
        "posts": posts.map(post).collect::<Vec<_>>(),
        "fields": fields.map(field).collect::<Vec<_>>(),
        "agents": agents.map(agent).collect::<Vec<_>>(),
        "trials": past.into_iter().map(trial).collect::<Vec<_>>(),
    });
    stamped(&arena.stamp, value)
}

fn field(field: &FieldTruth) -> Value {
    json!({
        "object_px": field.object_px,
        "goal_px": field.goal_px,
        "distance_px": field.distance_px,
        "e1_points": field.e1_points,
        "e2_points": field.e2_points,
        "points": field.points,
        "reached_frame": reached(field.reached_frame),
        "solved": field.solved != 0,
    })
}

fn agent(agent: &AgentTruth) -> Value {
    json!({
        "position_px": agent.position_px,
        "heading_steps": agent.heading_steps,
        "row": agent.row,
        "output": agent.output,
        "touches": agent.touches != 0,
    })
}

fn trial(trial: &TrialTruth) -> Value {
    json!({
        "trial": trial.trial,
        "goal": trial.goal,
        "distance_px": trial.distance_px,
        "reached_frame": reached(trial.reached_frame),
        "points": trial.points,
        "solved_fields": trial.solved_fields,
        "missed_frames": trial.missed_frames,
        "refused_frames": trial.refused_frames,
    })
}

/// Returns `null` if the object never reached its goal.
fn reached(frame: u32) -> Option<u32> {
    (frame > 0).then_some(frame)
}
