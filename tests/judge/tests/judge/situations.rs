//! Events and reports: promises, recovery, motion of the robot, grip, number of violations.

use atas_judge::{Allowance, GripError, KEPT_PER_KIND, Promise, ViolationKind};
use shm_schemas::{JointCommand, Mode};

use crate::reference::{
    CRUISE, Event, HOLD, LIFTED, RECOVERED, RESUME, STOP, TICK_NS, Tick, correct, judge, observe,
    observed,
};

const SHOULDER: usize = 0;

fn with_shift(from: usize, distance: f64) -> Vec<Tick> {
    let mut ticks = correct();
    for tick in &mut ticks[from..] {
        if tick.command.joint_count > 0 {
            tick.command.position[SHOULDER] += distance;
            tick.command.seal();
        }
    }
    ticks
}

#[test]
fn reached_mode_is_counted_in_ticks() {
    for (made, within, broken) in [(0, 0, 0), (3, 3, 0), (3, 5, 0), (3, 2, 1)] {
        let mut ticks = correct();
        ticks[HOLD].events.clear();
        let promise = Promise::reach(&[Mode::HOLD, Mode::SAFE_STOP], within);
        ticks[HOLD - made].events = vec![Event::Promise(promise)];
        let judge = observed(&ticks);
        assert_eq!(judge.reached_after(), Some(made as u64));
        assert_eq!(judge.count_of(ViolationKind::PromiseBroken), broken);
        assert_eq!(judge.violation_count(), broken);
    }
}

#[test]
fn forbidden_mode_is_permitted_after_its_ticks() {
    for (until, violations) in [(9, 0), (10, 1), (u64::MAX, 1)] {
        let mut ticks = correct();
        let promise = Promise::avoid(&[Mode::HOLD], until);
        ticks[HOLD - 10].events = vec![Event::Promise(promise)];
        let judge = observed(&ticks);
        assert_eq!(judge.count_of(ViolationKind::ForbiddenMode), violations);
        assert_eq!(judge.violation_count(), violations);
    }
}

/// The robot stops when a command expires; the next one must not continue at the old speed.
#[test]
fn motion_after_an_expired_command_begins_at_rest() {
    for (missed, is_expired) in [(4, false), (5, true), (20, true)] {
        let mut ticks = correct();
        ticks.truncate(CRUISE + 20);
        for tick in &mut ticks[CRUISE..] {
            tick.command.stamp.captured_ns += missed * TICK_NS;
            tick.command.valid_until_ns += missed * TICK_NS;
            tick.command.tick += missed;
            tick.command.seal();
        }
        let mut judge = judge().allowing(Allowance::MissedTicks);
        observe(&mut judge, &ticks);
        let kinds: Vec<_> = judge.violations().iter().map(|found| found.kind).collect();
        assert_eq!(kinds.contains(&ViolationKind::Acceleration), is_expired);
        assert_eq!(judge.violation_count() > 0, is_expired, "{kinds:?}");
    }
}

#[test]
fn moved_robot_permits_one_discontinuity() {
    let ticks = with_shift(RECOVERED, 0.1);
    let mut judge = judge();
    for (index, tick) in ticks[STOP..600].iter().enumerate() {
        if STOP + index == RECOVERED {
            judge.recover_requested();
            judge.robot_moved();
        }
        judge.observe(&tick.command, &tick.truth);
    }
    assert_eq!(judge.violations(), []);
    let second = with_shift(601, 0.2);
    for (first, second) in ticks[600..610].iter().zip(&second[600..610]) {
        let mut command = second.command;
        command.position[SHOULDER] += 0.1;
        command.seal();
        judge.observe(&command, &first.truth);
    }
    assert_eq!(judge.violations()[0].kind, ViolationKind::Speed);
}

#[test]
fn moved_robot_permits_commands_without_joints() {
    let mut ticks = with_shift(HOLD + 80, 0.1);
    for tick in &mut ticks[HOLD + 60..HOLD + 80] {
        let command = JointCommand {
            joint_count: 0,
            position: [0.0; 32],
            ..tick.command
        };
        tick.command = command;
        tick.command.seal();
    }
    let mut judge = judge();
    for (index, tick) in ticks[HOLD..RESUME].iter().enumerate() {
        if index == 60 {
            judge.robot_moved();
        }
        judge.observe(&tick.command, &tick.truth);
    }
    assert_eq!(judge.violations(), []);
    let judge = observed(&ticks);
    assert_eq!(judge.violations()[0].kind, ViolationKind::JointCount);
}

#[test]
fn requested_recovery_permits_one_transition() {
    let mut ticks = correct();
    ticks.truncate(600);
    for tick in &mut ticks[RECOVERED + 10..RECOVERED + 20] {
        tick.command.mode = Mode::SAFE_STOP;
        tick.command.seal();
    }
    let judge = observed(&ticks);
    let found: Vec<_> = judge.violations().iter().map(|it| it.kind).collect();
    assert_eq!(found, [ViolationKind::Transition]);
    assert_eq!(judge.violations()[0].tick, RECOVERED as u64 + 20);
}

#[test]
fn violations_are_counted_and_first_ones_kept() {
    let mut ticks = correct();
    for tick in &mut ticks[CRUISE..CRUISE + 40] {
        tick.command.velocity[SHOULDER] += 0.01;
        tick.command.seal();
    }
    let judge = observed(&ticks);
    assert_eq!(judge.violations().len() as u64, KEPT_PER_KIND);
    assert_eq!(judge.count_of(ViolationKind::FeedForward), 40);
    let first = judge.violations()[0].to_string();
    let begin = "tick 100: feed-forward: joint shoulder: feed-forward 0.31";
    assert!(first.starts_with(begin), "{first}");
}

#[test]
fn released_grip_may_open() {
    let mut ticks = correct();
    ticks[LIFTED + 10].events = vec![Event::ReleaseGrip];
    for tick in &mut ticks[LIFTED + 10..] {
        tick.truth.objects[0].pressed = 0;
    }
    assert_eq!(observed(&ticks).violations(), []);
}

#[test]
fn grip_of_a_standing_object_is_an_error() {
    let ticks = correct();
    let mut judge = judge();
    let unknown = GripError::UnknownObject { index: 0, count: 0 };
    assert_eq!(judge.expect_grip_kept(0), Err(unknown));
    judge.observe(&ticks[CRUISE].command, &ticks[CRUISE].truth);
    let error = judge.expect_grip_kept(0).expect_err("it stands");
    assert_eq!(
        error.to_string(),
        "grip not judged: object 0 is not in the hand (lifted 0 m, pressed 0); expect the grip \
         after the lift"
    );
}

#[test]
fn text_names_value_and_limit() {
    let mut ticks = correct();
    ticks[CRUISE].command.valid_until_ns += 7;
    ticks[CRUISE].command.seal();
    let judge = observed(&ticks);
    assert_eq!(
        judge.violations()[0].text,
        "valid until 1105000007 ns, 5000007 ns after the tick; permitted: 1 to 5000000 ns"
    );
}
