//! Intake of joint states: faults F40 and F41.

use crate::support::{EPOCH, MS_NS, home_rad, joints, robot};
use atas::Tick;
use atas::joints::JointIntake;
use atas::settings::{Intake as Limits, Settings};
use robot_model::ROBOT_JOINTS;
use shm_schemas::{Cause, JointState, Reason};

const START_NS: u64 = 1_000 * MS_NS;

fn tick(ms: u64) -> Tick {
    Tick {
        index: ms,
        now_ns: START_NS + ms * MS_NS,
    }
}

fn at(ms: u64) -> JointState {
    joints(ms, START_NS + ms * MS_NS, &home_rad())
}

fn limits() -> Limits {
    Settings::default().intake
}

fn warm() -> JointIntake {
    let mut intake = JointIntake::new(robot(), true);
    for ms in 0..10 {
        intake.take(Some(&at(ms)), tick(ms), &limits());
        assert!(!intake.fault().is_some());
    }
    intake
}

#[test]
fn every_fault_is_answered_as_catalogued() {
    type Change = fn(&mut JointState);
    let home_3_rad = home_rad()[3];
    let lower_4_rad = robot().joint(4).unwrap().lower_rad;
    let rows: [(&str, Change, u64, u64, Cause, u32); 15] = [
        ("in order", |_| {}, 1, 0, Cause::NONE, 0),
        (
            "lost states",
            |s| s.stamp.sequence += 4,
            1,
            4,
            Cause::NONE,
            0,
        ),
        ("duplicate", |s| s.stamp.sequence = 9, 0, 0, Cause::NONE, 0),
        ("reordered", |s| s.stamp.sequence = 3, 0, 0, Cause::NONE, 0),
        (
            "older than the last",
            |s| s.stamp.captured_ns = START_NS + 9 * MS_NS,
            0,
            0,
            Cause::NONE,
            0,
        ),
        (
            "stale",
            |s| s.stamp.captured_ns -= 200 * MS_NS,
            0,
            0,
            Cause::NONE,
            0,
        ),
        (
            "future",
            |s| s.stamp.captured_ns += 5 * MS_NS,
            0,
            0,
            Cause::NONE,
            0,
        ),
        (
            "NaN",
            |s| s.position_rad[7] = f64::NAN,
            0,
            0,
            Cause::JOINTS_INVALID,
            7,
        ),
        (
            "infinite",
            |s| s.position_rad[21] = f64::NEG_INFINITY,
            0,
            0,
            Cause::JOINTS_INVALID,
            21,
        ),
        (
            "jump",
            |s| s.position_rad[3] += 0.1,
            0,
            0,
            Cause::JOINTS_INVALID,
            3,
        ),
        ("fast", |s| s.position_rad[3] += 0.01, 1, 0, Cause::NONE, 0),
        (
            "too few joints",
            |s| s.joint_count = 21,
            0,
            0,
            Cause::JOINTS_INVALID,
            0,
        ),
        ("more joints", |s| s.joint_count = 32, 1, 0, Cause::NONE, 0),
        (
            "NaN beyond the robot's joints",
            |s| s.position_rad[ROBOT_JOINTS] = f64::NAN,
            1,
            0,
            Cause::NONE,
            0,
        ),
        (
            "NaN velocity, which nobody reads",
            |s| s.velocity_rad_s[0] = f64::NAN,
            1,
            0,
            Cause::NONE,
            0,
        ),
    ];
    for (fault, change, states, lost, cause, index) in rows {
        let mut intake = warm();
        let mut state = at(10);
        change(&mut state);
        intake.take(Some(&state), tick(10), &limits());
        let status = intake.status(tick(10));
        assert_eq!(
            (status.states, status.lost, status.rejected),
            (10 + states, lost, 1 - states),
            "{fault}"
        );
        assert_eq!(
            (intake.fault().cause, intake.fault().index),
            (cause, index),
            "{fault}"
        );
        assert!(
            intake.position_rad().unwrap().iter().all(|q| q.is_finite()),
            "{fault}"
        );
        assert_eq!(
            intake.sequence(),
            state.stamp.sequence,
            "lock-step waits for what was seen: {fault}"
        );
        // The fault lasts as long as the states are wrong.
        intake.take(Some(&at(16)), tick(16), &limits());
        assert_eq!(intake.fault(), Reason::default(), "after {fault}");
    }
    // The first state of a writer has no state before it, but a range.
    for (joint, value_rad) in [(0, 1e9), (3, home_3_rad + 10.0), (4, lower_4_rad - 0.1)] {
        let mut intake = JointIntake::new(robot(), true);
        let mut state = at(0);
        state.position_rad[joint] = value_rad;
        intake.take(Some(&state), tick(0), &limits());
        assert_eq!(
            (intake.fault().cause, intake.fault().index),
            (Cause::JOINTS_INVALID, joint as u32)
        );
        assert!(intake.position_rad().is_none());
    }
}

#[test]
fn silence_is_doubted_after_five_milliseconds() {
    let mut intake = warm();
    for (ms, cause) in [
        (10, Cause::NONE),
        (14, Cause::NONE),
        (15, Cause::JOINTS_STOPPED),
        (900, Cause::JOINTS_STOPPED),
    ] {
        intake.take(None, tick(ms), &limits());
        assert_eq!(intake.doubt(tick(ms), &limits()).cause, cause, "at {ms} ms");
    }
    assert_eq!(intake.status(tick(900)).age_ns, 891 * MS_NS);
}

#[test]
fn nothing_is_missed_where_nothing_is_required() {
    let intake = JointIntake::new(robot(), false);
    assert_eq!(intake.doubt(tick(0), &limits()), Reason::default());
    let intake = JointIntake::new(robot(), true);
    assert_eq!(
        intake.doubt(tick(0), &limits()).cause,
        Cause::JOINTS_STOPPED
    );
    assert_eq!(intake.status(tick(0)).age_ns, u64::MAX);
}

#[test]
fn a_restarted_writer_may_begin_anew() {
    let mut intake = warm();
    let mut state = at(10);
    (state.stamp.writer_epoch, state.stamp.sequence) = (EPOCH + 1, 0);
    intake.take(Some(&state), tick(10), &limits());
    assert_eq!(
        (intake.fault(), intake.status(tick(10)).states),
        (Reason::default(), 11)
    );
}
