//! The controller without a bus: tactile frames and joint states made by hand, 1 ms per tick.
//!
//! The servos of this example are perfect. The object is a wooden block, 50 mm wide, in front of
//! the right hand, and weighs 0.2 kg. Each fingertip that presses it measures 20 N per millimetre.
//!
//! `cargo run -p atas-core --example controller`

#![allow(clippy::print_stdout, reason = "an example prints its result")]

use atas_core::kinematics::{gap_m, grasp_pose};
use atas_core::{Controller, Inputs, OperatorRequest, SensorSetup, Settings, Tick, check};
use robot_model::{GraspSide, HandSide, HandVector, RobotModel, RobotVector};
use shm_schemas::{GoalKind, GoalRequest, Hand, HandFrame, JointState, Layout, Mode, Stamp};

const WIDTH_M: f64 = 0.05;
const STIFFNESS_N_M: f64 = 20_000.0;
const WEIGHT_N: f64 = 2.0;
/// Height of the grasp on the table, m.
const HEIGHT_M: f64 = 0.05;
const TICK_NS: u64 = 1_000_000;

/// Returns a frame in which the pole element of both fingertips measures a normal force and half
/// of the load.
fn frame(hand: Hand, stamp: Stamp, normal_n: f64, load_n: f64) -> HandFrame {
    let layout = Layout::dome_41();
    let mut frame = HandFrame {
        stamp,
        hand,
        layout_hash: layout.hash(),
        finger_count: 2,
        valid_mask: [(1 << layout.count) - 1, (1 << layout.count) - 1, 0, 0],
        ..HandFrame::default()
    };
    // Sensors have noise; constant readings count as a frozen sensor.
    let noise_n = (stamp.sequence % 7) as f32 * 1e-4;
    for finger in 0..2 {
        frame.force_n[finger][0] = [normal_n as f32 + noise_n, 0.0, -0.5 * load_n as f32];
    }
    frame.seal();
    frame
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = RobotModel::two_hand_arm()?;
    let mut controller = Controller::new(&robot, SensorSetup::default(), Settings::default());
    let mut position = RobotVector::zeros(robot.joint_count());
    for side in HandSide::BOTH {
        let range = robot.joint_range(side);
        position[range].copy_from_slice(robot.hand(side).reference());
    }
    let right = robot.hand(HandSide::Right);
    let right_rad =
        |q: &RobotVector| HandVector::from_slice(&q[robot.joint_range(HandSide::Right)]);
    let home = grasp_pose(right, &right.forward(&right_rad(&position)));
    let request = GoalRequest {
        goal_id: 1,
        kind: GoalKind::GRASP,
        hand: Hand::RIGHT,
        from_m: [home.centre_m.x, home.centre_m.y, HEIGHT_M],
        from_yaw_rad: std::f64::consts::FRAC_PI_2,
        width_m: WIDTH_M,
        lift_m: 0.04,
        hold_s: 0.5,
        ..GoalRequest::default()
    };
    let mut goal = None;
    let (mut shown, mut index) = (String::new(), 0);
    while index < 20_000 {
        let now_ns = 1_000_000_000 + index * TICK_NS;
        let stamp = Stamp {
            sequence: index,
            captured_ns: now_ns,
            writer_epoch: 1,
        };
        let pose = right.forward(&right_rad(&position));
        let gap_m = gap_m(&pose) - 2.0 * right.tip_radius_m()[0];
        let normal_n = (WIDTH_M - gap_m).max(0.0) / 2.0 * STIFFNESS_N_M;
        let is_lifted = pose.side_m(GraspSide::First).z > HEIGHT_M + 1e-3 && normal_n > 0.0;
        let load_n = if is_lifted { WEIGHT_N } else { 0.0 };
        let frames = [
            frame(Hand::LEFT, stamp, 0.0, 0.0),
            frame(Hand::RIGHT, stamp, normal_n, load_n),
        ];
        let mut joints = JointState {
            stamp,
            joint_count: robot.joint_count() as u32,
            ..JointState::default()
        };
        joints.position[..position.len()].copy_from_slice(&position);
        joints.seal();
        if controller.mode().0 == Mode::READY && goal.is_none() {
            let checked = check::check(&request, &controller.goal_context(&robot, &[]));
            goal = Some(checked.map_err(|reason| reason.to_string())?);
        }
        let start = goal
            .filter(|_| shown.starts_with("ready"))
            .map(OperatorRequest::Start);
        let outputs = controller.step(&Inputs {
            tick: Tick { index, now_ns },
            frames: [&frames[..1], &frames[1..]],
            joints: Some(&joints),
            request: start.as_ref(),
            ..Inputs::default()
        });
        let (command, update) = (outputs.command, outputs.goal_update);
        let count = command.joint_count as usize;
        position[..count].copy_from_slice(&command.position[..count]);
        let state = format!("{} {}", command.mode, controller.step_name());
        if state != shown {
            println!(
                "{index:6} ms  {state:20} F_n {normal_n:5.2} N, opening {:5.1} mm",
                gap_m * 1e3
            );
            shown = state;
        }
        if let Some(update) = update.filter(|update| update.state.is_final()) {
            println!("{index:6} ms  goal {}", update.state);
            break;
        }
        index += 1;
    }
    Ok(())
}
