//! Joint intake: faults F40 and F41.

use crate::support::JOINTS;
use crate::support::{EPOCH, MS_NS, home, joints, robot};
use atas_core::Tick;
use atas_core::joints::JointIntake;
use atas_core::settings::{Intake as Limits, Settings};
use shm_schemas::{Cause, JointState, Reason};

const START_NS: u64 = 1_000 * MS_NS;

fn tick(ms: u64) -> Tick {
    Tick {
        index: ms,
        now_ns: START_NS + ms * MS_NS,
    }
}

fn at(ms: u64) -> JointState {
    joints(ms, START_NS + ms * MS_NS, &home())
}

fn limits() -> Limits {
    Settings::default().intake
}

fn warm() -> JointIntake {
    let mut intake = JointIntake::new(robot(), true);
    for ms in 0..10 {
        intake.update(Some(&at(ms)), tick(ms), &limits());
        assert!(!intake.fault().is_some());
    }
    intake
}

type Change = fn(&mut JointState);

/// Fault that a state reports.
#[derive(Debug, PartialEq)]
enum Fault {
    None,
    Joint(usize),
    Count(u32),
}

struct Row {
    name: &'static str,
    change: Change,
    /// Number of lost states; `None` if the state is rejected.
    lost: Option<u64>,
    fault: Fault,
}

fn accepted(name: &'static str, lost: u64, change: Change) -> Row {
    Row {
        name,
        change,
        lost: Some(lost),
        fault: Fault::None,
    }
}

fn ignored(name: &'static str, change: Change) -> Row {
    Row {
        name,
        change,
        lost: None,
        fault: Fault::None,
    }
}

fn faulty(name: &'static str, fault: Fault, change: Change) -> Row {
    Row {
        name,
        change,
        lost: None,
        fault,
    }
}

fn rows() -> Vec<Row> {
    vec![
        accepted("in order", 0, |_| {}),
        accepted("lost states", 4, |s| s.stamp.sequence += 4),
        accepted("fast", 0, |s| s.position[3] += 0.01),
        accepted("NaN beyond the robot", 0, |s| s.position[JOINTS] = f64::NAN),
        accepted("NaN velocity, not read", 0, |s| s.velocity[0] = f64::NAN),
        ignored("duplicate", |s| s.stamp.sequence = 9),
        ignored("reordered", |s| s.stamp.sequence = 3),
        ignored("older than the last", |s| s.stamp.captured_ns -= MS_NS),
        ignored("stale", |s| s.stamp.captured_ns -= 200 * MS_NS),
        ignored("other writer beside a live one", |s| {
            s.stamp.writer_epoch += 1
        }),
        ignored("future", |s| s.stamp.captured_ns += 5 * MS_NS),
        faulty("NaN", Fault::Joint(7), |s| s.position[7] = f64::NAN),
        faulty("infinite", Fault::Joint(21), |s| {
            s.position[21] = f64::NEG_INFINITY
        }),
        faulty("jump", Fault::Joint(3), |s| s.position[3] += 0.1),
        faulty("too few joints", Fault::Count(21), |s| s.joint_count = 21),
        faulty("more joints", Fault::Count(32), |s| s.joint_count = 32),
        faulty("more joints than fit", Fault::Count(u32::MAX), |s| {
            s.joint_count = u32::MAX
        }),
    ]
}

#[test]
fn faults_are_handled_as_catalogued() {
    for Row {
        name,
        change,
        lost,
        fault,
    } in rows()
    {
        let mut intake = warm();
        let mut state = at(10);
        change(&mut state);
        state.seal();
        intake.update(Some(&state), tick(10), &limits());
        let status = intake.status(tick(10));
        let taken = u64::from(lost.is_some());
        assert_eq!(
            (status.states, status.rejected),
            (10 + taken, 1 - taken),
            "{name}"
        );
        assert_eq!(status.lost, lost.unwrap_or(0), "{name}");
        let found = match intake.fault() {
            Reason::None => Fault::None,
            Reason::JointsInvalid { joint, .. } => Fault::Joint(joint),
            Reason::JointCount { count, expected } if expected == JOINTS as u32 => {
                Fault::Count(count)
            }
            other => panic!("{name}: {other:?}"),
        };
        assert_eq!(found, fault, "{name}");
        assert!(
            intake.position().unwrap().iter().all(|q| q.is_finite()),
            "{name}"
        );
        assert_eq!(
            intake.sequence(),
            state.stamp.sequence,
            "lock-step uses the latest sequence: {name}"
        );
        intake.update(Some(&at(16)), tick(16), &limits());
        assert_eq!(intake.fault(), Reason::None, "after {name}");
    }
}

/// A writer's first state has no predecessor but must be within range.
#[test]
fn first_state_out_of_range_is_rejected() {
    let home_3_rad = home()[3];
    let lower_4_rad = robot().joint(4).unwrap().lower;
    for (joint, value_rad) in [(0, 1e9), (3, home_3_rad + 10.0), (4, lower_4_rad - 0.1)] {
        let mut intake = JointIntake::new(robot(), true);
        let mut state = at(0);
        state.position[joint] = value_rad;
        state.seal();
        intake.update(Some(&state), tick(0), &limits());
        let fault = intake.fault();
        assert!(
            matches!(fault, Reason::JointsInvalid { joint: named, .. } if named == joint),
            "{fault:?}"
        );
        assert!(intake.position().is_none());
    }
}

#[test]
fn silence_holds_after_five_milliseconds() {
    let mut intake = warm();
    for (ms, cause) in [
        (10, Cause::NONE),
        (14, Cause::NONE),
        (15, Cause::JOINTS_STOPPED),
        (900, Cause::JOINTS_STOPPED),
    ] {
        intake.update(None, tick(ms), &limits());
        assert_eq!(
            intake.hold_reason(tick(ms), &limits()).cause(),
            cause,
            "at {ms} ms"
        );
    }
    assert_eq!(intake.status(tick(900)).age_ns, 891 * MS_NS);
}

#[test]
fn missing_optional_feedback_causes_no_hold() {
    let intake = JointIntake::new(robot(), false);
    assert_eq!(intake.hold_reason(tick(0), &limits()), Reason::None);
    let intake = JointIntake::new(robot(), true);
    assert_eq!(
        intake.hold_reason(tick(0), &limits()).cause(),
        Cause::JOINTS_STOPPED
    );
    assert_eq!(intake.status(tick(0)).age_ns, u64::MAX);
}

#[test]
fn restarted_writer_is_accepted_after_silence() {
    let mut intake = warm();
    let other = |ms| {
        let mut state = at(ms);
        (state.stamp.writer_epoch, state.stamp.sequence) = (EPOCH + 1, ms - 15);
        state.seal();
        state
    };
    intake.update(Some(&other(15)), tick(15), &limits());
    assert_eq!(
        intake.status(tick(15)).states,
        10,
        "the first writer is live"
    );
    assert!(!intake.restarted());
    intake.update(Some(&other(40)), tick(40), &limits());
    assert_eq!(
        (intake.fault(), intake.status(tick(40)).states),
        (Reason::None, 11)
    );
    assert!(intake.restarted(), "reported once");
    intake.update(Some(&other(41)), tick(41), &limits());
    assert!(!intake.restarted());
}

/// Regression: one state with a counter far ahead blocked all others for the lifetime of the
/// process.
#[test]
fn counter_far_ahead_blocks_no_later_states() {
    let mut intake = warm();
    let mut far = at(10);
    far.stamp.sequence = u64::MAX / 2;
    far.seal();
    intake.update(Some(&far), tick(10), &limits());
    for ms in 11..40 {
        intake.update(Some(&at(ms)), tick(ms), &limits());
    }
    assert_eq!(intake.hold_reason(tick(40), &limits()), Reason::None);
}

#[test]
fn valid_commanded_positions_are_accepted() {
    let check = |output: bool, change: Change| {
        let mut intake = warm();
        let mut state = at(10);
        state.commanded_count = JOINTS as u32;
        state.commanded_position = state.position;
        state.command_epoch = 5;
        change(&mut state);
        state.seal();
        intake.update(Some(&state), tick(10), &limits());
        assert_eq!(intake.commanded_position().is_some(), output);
    };
    check(true, |_| {});
    check(false, |s| s.commanded_count = 0);
    check(false, |s| s.commanded_count = 21);
    check(false, |s| s.command_epoch = 0);
    check(false, |s| s.commanded_position[4] = f64::NAN);
    check(false, |s| s.commanded_position[4] = 100.0);
}
