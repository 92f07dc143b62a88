//! Messages on the bus: tactile frames, joint states, commands, goals, targets, control requests.
//!
//! A peer can write any bytes. An input holds instructions that change valid messages, and says for
//! each whether its checksum is repaired.

use std::sync::{Arc, LazyLock};

use atas_core::check::{self, GoalContext};
use atas_core::intake::FrameIntake;
use atas_core::joints::JointIntake;
use atas_core::record::{read_settings, write_settings};
use atas_core::{Controller, Goal, HandSensorSetup, Inputs, OperatorRequest, SensorSetup};
use atas_core::{Settings, Tick};
use atasd::config::{Config, Source, suggested_parameter};
use atasd::link::link;
use atasd::supervisor::{SupervisorState, execute_control};
use robot_model::{HandSide, RobotModel, RobotVector};
use shm_schemas::capacity::{FINGERS, HANDS};
use shm_schemas::{
    CommandValidator, ControlOp, ControlRequest, GoalKind, GoalRequest, GraspTarget, Hand,
    HandFrame, JointCommand, JointState, Layout, Mode, Stamp, Text,
};

use crate::input::Input;
use crate::target::Target;

/// Targets of this file.
pub(crate) const TARGETS: [Target; 8] = [
    Target::new("tactile-frame", tactile_frame, patch_seeds),
    Target::new("joint-state", joint_state, patch_seeds),
    Target::new("joint-command", joint_command, patch_seeds),
    Target::new("controller", controller, patch_seeds),
    Target::new("goal", goal, goal_seeds),
    Target::new("control", control, control_seeds),
    Target::new("parameters", parameters, patch_seeds),
    Target::new("parameter-name", parameter_name, name_seeds),
];

/// Most ticks of one input.
const TICKS_MAX: u64 = 24;
/// Start of time, ns.
const START_NS: u64 = 1_000_000_000;
const MS_NS: u64 = 1_000_000;

pub(crate) static ROBOT: LazyLock<RobotModel> =
    LazyLock::new(|| RobotModel::two_hand_arm().expect("a built-in robot"));

/// Instructions of some lengths: without a change, and with changes of all kinds.
fn patch_seeds() -> Vec<Vec<u8>> {
    let mut seeds = vec![vec![0; 64], Vec::new()];
    for width in 1..4 {
        for place in (0..64).step_by(7) {
            let tick = [
                1,
                0,
                1,
                width,
                place * 3,
                place / 16,
                place,
                1,
                2,
                3,
                4,
                5,
                6,
                7,
                8,
            ];
            seeds.push(tick.repeat(6));
        }
    }
    seeds
}

/// Time of the next tick: usually a millisecond later, otherwise any.
fn next_ns(now_ns: u64, input: &mut Input<'_>) -> u64 {
    match input.byte() {
        0..=223 => now_ns.saturating_add(MS_NS),
        224..=239 => now_ns,
        _ => input.u64(),
    }
}

fn frame(hand: Hand, stamp: Stamp) -> HandFrame {
    let layout = Layout::dome_41();
    let mut frame = HandFrame {
        stamp,
        hand,
        layout_hash: layout.hash(),
        finger_count: 2,
        valid_mask: [(1 << layout.count) - 1, (1 << layout.count) - 1, 0, 0],
        ..HandFrame::default()
    };
    for finger in 0..2 {
        frame.force_n[finger][0] = [1.0 + (stamp.sequence % 7) as f32 * 1e-3, 0.1, -0.2];
    }
    frame
}

fn stamp(sequence: u64, captured_ns: u64) -> Stamp {
    Stamp {
        sequence,
        captured_ns,
        writer_epoch: 1,
    }
}

/// Changes a frame as the input says.
fn changed_frame(hand: Hand, stamp: Stamp, input: &mut Input<'_>) -> HandFrame {
    let mut frame = frame(hand, stamp);
    let kind = input.byte();
    if kind < 16 {
        frame.seal();
        input.patch(&mut frame);
    } else {
        input.patch(&mut frame);
        frame.seal();
    }
    frame
}

fn tactile_frame(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let limits = Settings::default().intake;
    let mut intake = FrameIntake::new(Hand::LEFT, &HandSensorSetup::default());
    let mut now_ns = START_NS;
    for index in 0..TICKS_MAX {
        let tick = Tick { index, now_ns };
        let frame = changed_frame(Hand::LEFT, stamp(index, now_ns), &mut input);
        intake.begin();
        let is_valid = intake.validate(&frame, tick, &limits).is_some();
        assert!(
            !is_valid || frame.is_intact(),
            "a damaged frame is accepted"
        );
        let _reasons = (intake.hold_reason(tick, &limits), intake.warning());
        let _ages = (
            intake.age_ns(tick),
            intake.sequence(),
            intake.writer_epoch(),
        );
        if input.is_empty() {
            break;
        }
        now_ns = next_ns(now_ns, &mut input);
    }
}

/// Sealed state of the home posture.
fn home_state(stamp: Stamp) -> JointState {
    let mut state = JointState {
        stamp,
        joint_count: ROBOT.joint_count() as u32,
        ..JointState::default()
    };
    let home = home();
    state.position[..home.len()].copy_from_slice(&home);
    state.seal();
    state
}

fn home() -> RobotVector {
    let mut home = RobotVector::zeros(ROBOT.joint_count());
    for side in HandSide::BOTH {
        home[ROBOT.joint_range(side)].copy_from_slice(ROBOT.hand(side).reference());
    }
    home
}

fn changed_state(stamp: Stamp, input: &mut Input<'_>) -> JointState {
    let mut state = home_state(stamp);
    let kind = input.byte();
    input.patch(&mut state);
    if kind >= 16 {
        state.seal();
    }
    state
}

fn joint_state(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let limits = Settings::default().intake;
    let mut intake = JointIntake::new(&ROBOT, true);
    let mut now_ns = START_NS;
    for index in 0..TICKS_MAX {
        let tick = Tick { index, now_ns };
        let state = changed_state(stamp(index, now_ns), &mut input);
        intake.update(Some(&state), tick, &limits);
        let read = [
            intake.position(),
            intake.commanded_position(),
            intake.effort(),
        ];
        for joints in read.into_iter().flatten() {
            assert!(
                joints.iter().all(|value| value.is_finite()),
                "an invalid value is accepted"
            );
        }
        let _reasons = (intake.hold_reason(tick, &limits), intake.fault());
        let _status = (
            intake.status(tick),
            intake.fresh_position(tick, &limits).is_some(),
        );
        if input.is_empty() {
            break;
        }
        now_ns = next_ns(now_ns, &mut input);
    }
}

fn joint_command(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let home = home();
    let mut validator = CommandValidator::new(&home, &[1.0; 64]);
    let mut now_ns = START_NS;
    for index in 0..TICKS_MAX {
        let mut command = JointCommand {
            stamp: stamp(index, now_ns),
            joint_count: home.len() as u32,
            valid_until_ns: now_ns.saturating_add(20 * MS_NS),
            ..JointCommand::default()
        };
        command.position[..home.len()].copy_from_slice(&home);
        let kind = input.byte();
        input.patch(&mut command);
        if kind >= 16 {
            command.seal();
        }
        if let Some(accepted) = validator.accept(&command, now_ns) {
            let values = accepted.setpoints.position.iter();
            assert!(
                values
                    .chain(&accepted.setpoints.velocity)
                    .all(|value| value.is_finite())
            );
            accepted.write_to(&mut home_state(stamp(index, now_ns)));
        }
        if input.is_empty() {
            break;
        }
        now_ns = next_ns(now_ns, &mut input);
    }
}

fn reachable_goal(index: u64) -> GoalRequest {
    let kinds = GoalKind::ALL;
    GoalRequest {
        goal_id: index,
        kind: kinds[index as usize % kinds.len()],
        hand: Hand::RIGHT,
        from_m: [0.35, -0.2, 0.05],
        from_yaw_rad: core::f64::consts::FRAC_PI_2,
        to_m: [0.35, 0.2, 0.05],
        to_yaw_rad: core::f64::consts::FRAC_PI_2,
        width_m: 0.05,
        lift_m: 0.04,
        hold_s: 0.5,
        helper_width_m: 0.05,
        ..GoalRequest::default()
    }
}

/// Request of the supervisor: values that it would have checked stay within their ranges.
fn operator_request(index: u64, input: &mut Input<'_>) -> Option<OperatorRequest> {
    Some(match input.byte() {
        1..=16 => {
            let mut request = reachable_goal(index % 8);
            let finite = request;
            input.patch(&mut request);
            let is_finite = request.values().iter().all(|value| value.is_finite());
            let request = if is_finite { request } else { finite };
            OperatorRequest::Start(Goal::resolve(&request, &[]).ok()?)
        }
        17 => OperatorRequest::Cancel {
            goal_id: u64::from(input.byte()),
        },
        18 => OperatorRequest::ClientDisconnected {
            goal_id: u64::from(input.byte()),
        },
        19 => OperatorRequest::Recover,
        20 => OperatorRequest::Bias {
            hand: usize::from(input.byte()) % HANDS,
        },
        _ => return None,
    })
}

fn changed_target(stamp: Stamp, input: &mut Input<'_>) -> GraspTarget {
    let mut target = GraspTarget {
        stamp,
        valid_until_ns: stamp.captured_ns.saturating_add(100 * MS_NS),
        hand: Hand::RIGHT,
        centre_m: [0.35, -0.2, 0.15],
        opening_m: 0.06,
        ..GraspTarget::default()
    };
    input.patch(&mut target);
    if input.byte() >= 16 {
        target.seal();
    }
    target
}

/// Whole controller: every message of a tick is changed.
fn controller(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let mut controller = Controller::new(&ROBOT, SensorSetup::default(), Settings::default());
    let mut now_ns = START_NS;
    for index in 0..TICKS_MAX {
        let frames = Hand::BOTH.map(|hand| changed_frame(hand, stamp(index, now_ns), &mut input));
        let counts = input.byte();
        let joints = changed_state(stamp(index, now_ns), &mut input);
        let target = changed_target(stamp(index, now_ns), &mut input);
        let request = operator_request(index, &mut input);
        let outputs = controller.step(&Inputs {
            tick: Tick { index, now_ns },
            frames: [
                &frames[..usize::from(counts & 1 == 0)],
                &frames[1..2 - usize::from(counts & 2 != 0)],
            ],
            joints: (counts & 4 == 0).then_some(&joints),
            targets: core::slice::from_ref(&target),
            request: request.as_ref(),
        });
        let command = &outputs.command;
        let values = command.position.iter().chain(&command.velocity);
        assert!(command.is_intact() && values.clone().all(|value| value.is_finite()));
        if input.is_empty() {
            break;
        }
        // Ticks of the daemon follow a clock that does not jump.
        now_ns = now_ns.saturating_add(match input.byte() {
            0..=223 => MS_NS,
            other => u64::from(other) * MS_NS,
        });
    }
}

fn goal_seeds() -> Vec<Vec<u8>> {
    (0..GoalKind::ALL.len() as u8)
        .flat_map(|kind| [vec![kind, 0, 0, 0], vec![kind, 1, 1, 3]])
        .collect()
}

fn goal(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let mut request = reachable_goal(u64::from(input.byte()) % 8);
    let is_positioned = input.byte() & 1 == 0;
    request.task = Text::new("fetch");
    input.patch(&mut request);
    let (wiring, settings, home) = (SensorSetup::default(), Settings::default(), home());
    let now = GoalContext {
        robot: &ROBOT,
        wiring: &wiring,
        settings: &settings,
        tasks: &[],
        commanded_position: is_positioned.then_some(&home),
    };
    match check::check(&request, &now) {
        Ok(goal) => assert!(goal.clearance_margin_m().is_finite()),
        Err(reason) => assert!(!reason.to_string().is_empty()),
    }
}

fn control_seeds() -> Vec<Vec<u8>> {
    let mut seeds = Vec::new();
    for op in 0..=ControlOp::ALL.len() as u8 {
        for name in ["", "grasp.slip_latch_s", "safety.valid_s", "7"] {
            let mut seed = vec![op, 0, 14];
            seed.extend(name.as_bytes());
            seeds.push(seed);
        }
    }
    seeds
}

fn control(bytes: &[u8]) {
    static CONFIG: LazyLock<Config> = LazyLock::new(Config::default);
    let mut input = Input::new(bytes);
    let wiring = CONFIG.sensor_setup(&ROBOT, 1).expect("a valid default");
    let source = Source {
        files: Vec::new(),
        flags: vec!["realtime.mode=\"off\"".to_owned()],
    };
    let mut state = SupervisorState::new(source, CONFIG.clone(), ROBOT.clone(), wiring, 0);
    let (_tick, mut link) = link(false, Arc::default());
    let (op, flags) = (input.byte(), input.byte());
    state.flags = u32::from(flags >> 4);
    state.mode = Mode(u32::from(flags & 15));
    let value = f64::from_bits(input.u64());
    let name = String::from_utf8_lossy(input.rest()).into_owned();
    let request = ControlRequest {
        op: ControlOp::ALL
            .get(usize::from(op))
            .copied()
            .unwrap_or(ControlOp(u32::from(op))),
        value,
        name: Text::new(&name),
        ..ControlRequest::default()
    };
    if let Some(reply) = execute_control(&request, &mut state, &mut link) {
        let _text = (reply.text.as_str(), format!("{:?}", reply.outcome));
    }
}

/// Settings as bytes: a record of any origin gives valid settings or an error.
fn parameters(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let mut record = write_settings(&Settings::default());
    input.patch(&mut record);
    input.patch(&mut record);
    match read_settings(&record) {
        Ok(settings) => assert!(settings.check().is_ok()),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

fn name_seeds() -> Vec<Vec<u8>> {
    let names = atas_core::settings::PARAMETERS
        .iter()
        .map(|parameter| parameter.name);
    names
        .take(40)
        .map(|name| format!("{name}=0.5").into_bytes())
        .collect()
}

/// Name and value of a parameter as text.
fn parameter_name(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let (name, value) = text.split_once('=').unwrap_or((&text, ""));
    let mut settings = Settings::default();
    if let Err(error) = settings.set(name, value.parse().unwrap_or(f64::NAN)) {
        assert!(!error.to_string().is_empty());
    }
    assert!(settings.check().is_ok(), "an invalid setting is stored");
    let _meant = suggested_parameter(name);
}

const _: () = assert!(FINGERS >= 2);
