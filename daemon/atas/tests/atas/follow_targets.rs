//! Target intake: acceptance and rejection reasons.

use atas_core::Tick;
use atas_core::follow::TargetIntake;
use atas_core::goal::ActiveGoal;
use robot_model::Side;
use shm_schemas::{Cause, GoalKind, GoalRequest, GraspTarget, GripOrder, Hand, Stamp};

use crate::support::{MS_NS, robot};
use crate::world::start;
use atas_core::Order;

/// Writer epoch of the client.
const CLIENT: u64 = 31;
/// Start time of the goal.
const BEGIN_MS: u64 = 1_000;

fn tick(ms: u64) -> Tick {
    Tick {
        index: ms,
        now_ns: ms * MS_NS,
    }
}

fn listening(kind: GoalKind) -> TargetIntake {
    let request = GoalRequest {
        stamp: Stamp {
            writer_epoch: CLIENT,
            ..Stamp::default()
        },
        goal_id: 1,
        kind,
        hand: Hand::RIGHT,
        ..GoalRequest::default()
    };
    let Order::Start(goal) = start(request) else {
        unreachable!("an order to start")
    };
    let mut intake = TargetIntake::new(robot());
    intake.follow(Some(&ActiveGoal::begin(&goal)), tick(BEGIN_MS));
    intake
}

fn target(sequence: u64, made_ms: u64) -> GraspTarget {
    GraspTarget {
        stamp: Stamp {
            sequence,
            captured_ns: made_ms * MS_NS,
            writer_epoch: CLIENT,
        },
        valid_until_ns: (made_ms + 300) * MS_NS,
        hand: Hand::RIGHT,
        grip: GripOrder::WIDTH,
        centre_m: [0.32, -0.15, 0.05],
        closing_yaw_rad: 0.3,
        opening_m: 0.06,
        ..GraspTarget::default()
    }
}

fn sealed(mut target: GraspTarget) -> GraspTarget {
    target.seal();
    target
}

type Change = fn(&mut GraspTarget);

#[test]
fn every_bad_target_is_refused_by_its_cause_and_changes_nothing() {
    let table: &[(Change, Cause, u32)] = &[
        (|t| t.stamp.writer_epoch = 32, Cause::TARGET_FOREIGN, 0),
        (|t| t.stamp.sequence = 4, Cause::TARGET_STALE, 0),
        (|t| t.valid_until_ns = 1_000 * MS_NS, Cause::TARGET_STALE, 0),
        (|t| t.valid_until_ns = 0, Cause::TARGET_STALE, 0),
        (
            |t| t.stamp.captured_ns = 980 * MS_NS,
            Cause::TARGET_STALE,
            0,
        ),
        (|t| t.stamp.captured_ns = u64::MAX, Cause::TARGET_STALE, 0),
        (|t| t.hand = Hand::LEFT, Cause::TARGET_UNKNOWN, 0),
        (|t| t.hand = Hand(9), Cause::TARGET_UNKNOWN, 0),
        (|t| t.grip = GripOrder(7), Cause::TARGET_UNKNOWN, 0),
        (|t| t.centre_m[1] = f64::NAN, Cause::TARGET_NOT_FINITE, 1),
        (
            |t| t.closing_yaw_rad = f64::INFINITY,
            Cause::TARGET_NOT_FINITE,
            3,
        ),
        (|t| t.opening_m = f64::NAN, Cause::TARGET_NOT_FINITE, 4),
        (|t| t.centre_m[0] = 0.5, Cause::TARGET_OUT_OF_RANGE, 0),
        (|t| t.centre_m[1] = 0.05, Cause::TARGET_OUT_OF_RANGE, 1),
        (|t| t.centre_m[2] = 0.0, Cause::TARGET_OUT_OF_RANGE, 2),
        (|t| t.closing_yaw_rad = 7.0, Cause::TARGET_OUT_OF_RANGE, 3),
        (|t| t.opening_m = 0.2, Cause::TARGET_OUT_OF_RANGE, 4),
        (|t| t.opening_m = -0.001, Cause::TARGET_OUT_OF_RANGE, 4),
    ];
    for (index, (change, cause, about)) in table.iter().enumerate() {
        let mut intake = listening(GoalKind::FOLLOW);
        let good = sealed(target(5, 1_001));
        assert!(!intake.take(&[good], tick(1_002)).is_some(), "{index}");
        let before = *intake.of(Side::Right).expect("believed");
        let mut bad = target(6, 1_002);
        change(&mut bad);
        let reason = intake.take(&[sealed(bad)], tick(1_003));
        assert_eq!(
            (reason.cause, reason.index),
            (*cause, *about),
            "{index}: {reason}"
        );
        assert_eq!(intake.of(Side::Right), Some(&before), "{index}");
        assert!(
            !intake
                .take(&[sealed(target(6, 1_003))], tick(1_004))
                .is_some()
        );
        assert_ne!(intake.of(Side::Right), Some(&before), "{index}: it goes on");
    }
    let mut intake = listening(GoalKind::FOLLOW);
    let mut torn = sealed(target(0, 1_001));
    torn.centre_m[0] += 1e-3;
    assert_eq!(
        intake.take(&[torn], tick(1_002)).cause,
        Cause::TARGET_CORRUPT
    );
}

#[test]
fn held_is_wanted_whatever_the_width() {
    let mut intake = listening(GoalKind::FOLLOW);
    let hold = GraspTarget {
        grip: GripOrder::HOLD,
        opening_m: -1.0,
        ..target(0, 1_001)
    };
    assert!(!intake.take(&[sealed(hold)], tick(1_001)).is_some());
    assert_eq!(
        intake.of(Side::Right).map(|t| t.grip()),
        Some(GripOrder::HOLD)
    );
}

#[test]
fn the_newest_counts_until_it_expires_and_two_seconds_at_most() {
    let mut intake = listening(GoalKind::FOLLOW_BOTH);
    let left = GraspTarget {
        hand: Hand::LEFT,
        centre_m: [0.3, 0.2, 0.1],
        ..target(2, 1_001)
    };
    let first = target(0, 1_001);
    let second = GraspTarget {
        opening_m: 0.05,
        valid_until_ns: u64::MAX,
        ..target(1, 1_001)
    };
    let all = [first, second, left].map(sealed);
    assert!(!intake.take(&all, tick(1_002)).is_some());
    assert_eq!(intake.of(Side::Right).map(|t| t.opening_m()), Some(0.05));
    assert_eq!(intake.of(Side::Left).map(|t| t.opening_m()), Some(0.06));
    assert!(!intake.take(&[], tick(1_301)).is_some());
    let silent = intake.take(&[], tick(1_302));
    assert_eq!((silent.cause, silent.index), (Cause::TARGETS_STOPPED, 0));
    assert_eq!(intake.of(Side::Left), None);
    assert!(!intake.take(&[], tick(3_002)).is_some());
    assert!(intake.of(Side::Right).is_some());
    let silent = intake.take(&[], tick(3_003));
    assert_eq!((silent.cause, silent.index), (Cause::TARGETS_STOPPED, 1));
    assert_eq!(intake.of(Side::Right), None);
}

#[test]
fn a_bad_stream_is_told_of_once_a_second() {
    let mut intake = listening(GoalKind::FOLLOW);
    let bad = |sequence, ms| {
        sealed(GraspTarget {
            opening_m: f64::NAN,
            ..target(sequence, ms)
        })
    };
    let told = (1_001..4_001)
        .filter(|ms| intake.take(&[bad(*ms, *ms)], tick(*ms)).is_some())
        .count();
    assert_eq!(told, 3);
}

#[test]
fn nobody_is_heard_without_a_goal_that_opens_the_stream() {
    let mut intake = TargetIntake::new(robot());
    let good = sealed(target(0, 1_001));
    assert!(!intake.take(&[good], tick(1_001)).is_some());
    assert_eq!(intake.of(Side::Right), None);
    for kind in [GoalKind::GRASP, GoalKind::RELEASE] {
        let mut intake = listening(kind);
        assert!(!intake.take(&[good], tick(1_001)).is_some());
        assert_eq!(intake.of(Side::Right), None);
    }
    let mut intake = listening(GoalKind::FOLLOW);
    intake.take(&[good], tick(1_001));
    intake.follow(None, tick(1_002));
    assert_eq!(intake.of(Side::Right), None);
}
