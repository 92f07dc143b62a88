//! Target intake: acceptance and rejection reasons.

use atas_core::Tick;
use atas_core::goal::ActiveGoal;
use atas_core::teleop::TargetIntake;
use robot_model::HandSide;
use shm_schemas::{
    Cause, GoalKind, GoalRequest, GraspTarget, GripOrder, Hand, Reason, ReasonRecord, Stamp,
};

use crate::support::{MS_NS, robot};
use crate::world::start;
use atas_core::OperatorRequest;

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

fn intake_with_goal(kind: GoalKind) -> TargetIntake {
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
    let OperatorRequest::Start(goal) = start(request) else {
        unreachable!("a start request")
    };
    let mut intake = TargetIntake::new(robot());
    intake.set_goal(Some(&ActiveGoal::begin(&goal)), tick(BEGIN_MS));
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
fn invalid_targets_are_rejected_without_effect() {
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
        let mut intake = intake_with_goal(GoalKind::TELEOP);
        let good = sealed(target(5, 1_001));
        assert!(!intake.update(&[good], tick(1_002)).is_some(), "{index}");
        let before = *intake.target(HandSide::Right).expect("accepted");
        let mut bad = target(6, 1_002);
        change(&mut bad);
        let reason = ReasonRecord::from(intake.update(&[sealed(bad)], tick(1_003)));
        assert_eq!(
            (reason.cause, reason.index),
            (*cause, *about),
            "{index}: {reason}"
        );
        assert_eq!(intake.target(HandSide::Right), Some(&before), "{index}");
        assert!(
            !intake
                .update(&[sealed(target(6, 1_003))], tick(1_004))
                .is_some()
        );
        assert_ne!(
            intake.target(HandSide::Right),
            Some(&before),
            "{index}: the stream continues"
        );
    }
    let mut intake = intake_with_goal(GoalKind::TELEOP);
    let mut torn = sealed(target(0, 1_001));
    torn.centre_m[0] += 1e-3;
    assert_eq!(intake.update(&[torn], tick(1_002)), Reason::TargetCorrupt);
}

#[test]
fn hold_command_ignores_the_width() {
    let mut intake = intake_with_goal(GoalKind::TELEOP);
    let hold = GraspTarget {
        grip: GripOrder::HOLD,
        opening_m: -1.0,
        ..target(0, 1_001)
    };
    assert!(!intake.update(&[sealed(hold)], tick(1_001)).is_some());
    assert_eq!(
        intake.target(HandSide::Right).map(|t| t.grip()),
        Some(GripOrder::HOLD)
    );
}

#[test]
fn newest_target_is_valid_for_two_seconds_at_most() {
    let mut intake = intake_with_goal(GoalKind::TELEOP_BOTH);
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
    assert!(!intake.update(&all, tick(1_002)).is_some());
    assert_eq!(
        intake.target(HandSide::Right).map(|t| t.opening_m()),
        Some(0.05)
    );
    assert_eq!(
        intake.target(HandSide::Left).map(|t| t.opening_m()),
        Some(0.06)
    );
    assert!(!intake.update(&[], tick(1_301)).is_some());
    let silent = intake.update(&[], tick(1_302));
    assert_eq!(silent, Reason::TargetsStopped { hand: Hand::LEFT });
    assert_eq!(intake.target(HandSide::Left), None);
    assert!(!intake.update(&[], tick(3_002)).is_some());
    assert!(intake.target(HandSide::Right).is_some());
    let silent = intake.update(&[], tick(3_003));
    assert_eq!(silent, Reason::TargetsStopped { hand: Hand::RIGHT });
    assert_eq!(intake.target(HandSide::Right), None);
}

#[test]
fn invalid_stream_warns_once_per_second() {
    let mut intake = intake_with_goal(GoalKind::TELEOP);
    let bad = |sequence, ms| {
        sealed(GraspTarget {
            opening_m: f64::NAN,
            ..target(sequence, ms)
        })
    };
    let output = (1_001..4_001)
        .filter(|ms| intake.update(&[bad(*ms, *ms)], tick(*ms)).is_some())
        .count();
    assert_eq!(output, 3);
}

#[test]
fn targets_without_teleoperation_goal_are_ignored() {
    let mut intake = TargetIntake::new(robot());
    let good = sealed(target(0, 1_001));
    assert!(!intake.update(&[good], tick(1_001)).is_some());
    assert_eq!(intake.target(HandSide::Right), None);
    for kind in [GoalKind::GRASP, GoalKind::RELEASE] {
        let mut intake = intake_with_goal(kind);
        assert!(!intake.update(&[good], tick(1_001)).is_some());
        assert_eq!(intake.target(HandSide::Right), None);
    }
    let mut intake = intake_with_goal(GoalKind::TELEOP);
    intake.update(&[good], tick(1_001));
    intake.set_goal(None, tick(1_002));
    assert_eq!(intake.target(HandSide::Right), None);
}
