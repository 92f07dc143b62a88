//! Tests of the robot without ports: reported states, accepted commands, failures.

use std::sync::OnceLock;

use atas_robots::joints::{self, Joint};
use atas_robots::map::JointReading;
use atas_robots::port::Report;
use atas_robots::robot::{Change, Robot};
use proptest::prelude::*;
use shm_schemas::JointCommand;
use shm_schemas::capacity::JOINTS;

const MS_NS: u64 = 1_000_000;

/// Loaded once, because the property tests use it often.
fn joints() -> &'static [Joint] {
    static JOINTS: OnceLock<Vec<Joint>> = OnceLock::new();
    JOINTS.get_or_init(|| joints::load("two-hand-arm").unwrap())
}

fn held(joint: usize) -> f64 {
    0.5 * (joints()[joint].lower + joints()[joint].upper)
}

fn holding(life: u32, joints: core::ops::Range<usize>) -> Report {
    Report::Holding {
        session: life,
        held: joints.map(|joint| (joint, held(joint))).collect(),
    }
}

fn read(captured_ns: u64, joints: core::ops::Range<usize>) -> Report {
    let reading = |joint| JointReading {
        position: held(joint),
        ..JointReading::default()
    };
    Report::Read {
        captured_ns,
        joints: joints.map(|joint| (joint, reading(joint))).collect(),
    }
}

/// Creates a robot whose two ports hold.
fn ready_robot() -> Robot {
    let mut robot = Robot::new(joints().to_vec(), 2, || 5);
    assert_eq!(robot.report(0, holding(1, 0..11)), Change::None);
    assert_eq!(robot.report(1, holding(1, 11..22)), Change::Ready);
    robot
}

fn command(sequence: u64) -> JointCommand {
    let mut command = JointCommand {
        joint_count: 22,
        valid_until_ns: 50 * MS_NS,
        ..JointCommand::default()
    };
    (0..22).for_each(|joint| command.position[joint] = held(joint));
    (command.stamp.sequence, command.stamp.writer_epoch) = (sequence, 7);
    command.seal();
    command
}

#[test]
fn state_requires_all_ports_and_has_oldest_time() {
    let mut robot = ready_robot();
    assert!(robot.state().is_none());
    robot.report(0, read(3, 0..11));
    robot.report(0, read(6, 0..11));
    assert!(robot.state().is_none(), "one port is missing");
    robot.report(1, read(4, 11..22));
    let state = robot.state().unwrap();
    assert!(state.is_intact());
    assert_eq!((state.stamp.captured_ns, state.stamp.sequence), (4, 0));
    assert_eq!((state.joint_count, state.commanded_count), (22, 22));
    assert!(robot.state().is_none(), "no state is sent twice");
}

#[test]
fn port_that_fails_before_all_hold_is_no_failed_take_over() {
    let mut robot = Robot::new(joints().to_vec(), 2, || 5);
    let failure = || Report::Failure("a failure".to_owned());
    let failed = || Change::Failed("a failure".to_owned());
    assert_eq!(robot.report(0, holding(1, 0..11)), Change::None);
    assert_eq!(robot.report(0, failure()), failed());
    assert_eq!(robot.report(0, failure()), Change::None, "known failure");
    assert_eq!(robot.report(1, holding(1, 11..22)), Change::None);
    assert_eq!(robot.report(0, holding(2, 0..11)), Change::Ready);
}

#[test]
fn failure_stops_states_until_next_session() {
    let mut robot = ready_robot();
    assert!(robot.command(&command(1), 0));
    assert_eq!(robot.setpoints(1).map(|(life, _)| life), Some(1));
    let why = "a failure".to_owned();
    assert_eq!(
        robot.report(1, Report::Failure(why.clone())),
        Change::Failed(why.clone())
    );
    assert_eq!(
        robot.report(1, Report::Failure(why)),
        Change::None,
        "known failure"
    );
    assert_eq!(
        robot.report(1, Report::Failure("another failure".to_owned())),
        Change::TakeOverFailed("another failure".to_owned())
    );
    robot.report(0, read(1, 0..11));
    robot.report(1, read(1, 11..22));
    assert!(robot.state().is_none() && robot.setpoints(0).is_none());
    assert!(!robot.command(&command(2), MS_NS));

    assert_eq!(robot.report(1, holding(2, 11..22)), Change::Ready);
    assert!(
        robot.setpoints(1).is_none(),
        "no command was accepted in this session"
    );
    assert!(
        robot.command(&command(1), 2 * MS_NS),
        "any writer may start"
    );
    assert_eq!(robot.setpoints(1).map(|(life, _)| life), Some(2));
}

#[test]
fn command_without_joints_is_not_counted() {
    let mut robot = ready_robot();
    let mut answer = JointCommand::default();
    answer.seal();
    assert!(!robot.command(&answer, 0));
    assert_eq!(robot.rejected(), 0);
}

proptest! {
    /// Property: all set-points are finite, within the limits, and reachable at the joints' speed.
    #[test]
    fn setpoints_stay_within_limits(
        steps in proptest::collection::vec((0..22_usize, -20.0..20.0_f64, 0..4_u8, 0..200_u64), 1..60),
    ) {
        let (mut robot, known) = (ready_robot(), joints());
        let mut last_rad: [f64; JOINTS] = core::array::from_fn(|joint| if joint < 22 { held(joint) } else { 0.0 });
        let (mut next, mut now_ns, mut obeyed_ns) = (command(0), 0, None);
        for (joint, by_rad, odd, later_ms) in steps {
            now_ns += later_ms * MS_NS;
            next.stamp.sequence += 1;
            next.valid_until_ns = now_ns + 50 * MS_NS;
            next.position = last_rad;
            next.position[joint] += match odd {
                0 => by_rad,
                1 => 0.001 * by_rad,
                2 => f64::NAN,
                _ => f64::INFINITY * by_rad,
            };
            next.seal();
            if robot.command(&next, now_ns) {
                let (_, ordered_rad) = robot.setpoints(0).unwrap();
                let since_s = obeyed_ns.map_or(0.0, |then: u64| (now_ns - then) as f64 * 1e-9);
                for (index, limits) in known.iter().enumerate() {
                    let q = ordered_rad[index];
                    prop_assert!(q >= limits.lower - 1e-5 && q <= limits.upper + 1e-5);
                    let farthest_rad = 1.05 * limits.speed_max_rad_s * (0.008 + since_s.min(0.1));
                    prop_assert!((q - last_rad[index]).abs() <= farthest_rad + 1e-9);
                }
                last_rad = *ordered_rad;
                obeyed_ns = Some(now_ns);
            }
        }
    }
}
