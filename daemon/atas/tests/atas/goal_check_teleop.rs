//! Goal check: sides and workspaces of teleoperated arms.

use crate::goal::goal;
use crate::goal_check::{check_on, refusal};
use crate::support::{angular_jaw, home_of, robot, test_bench};
use atas_core::Settings;
use atas_core::check;
use nalgebra::Vector3;
use robot_model::{GraspPose, HandSide, HandVector, RobotVector, nearest};
use shm_schemas::{Cause, GoalKind, GoalRequest, Hand, Reason};

/// Posture with the grasp of each side at this place.
fn postures(left_m: [f64; 3], right_m: [f64; 3]) -> RobotVector {
    let mut q = home_of(robot());
    for (side, centre_m) in [(HandSide::Left, left_m), (HandSide::Right, right_m)] {
        let (hand, centre_m) = (robot().hand(side), Vector3::from(centre_m));
        let yaw_rad = hand.closing_yaw_rad(&centre_m, 0.0);
        let pose = GraspPose::from_above(centre_m, yaw_rad, 0.05);
        q[robot().joint_range(side)].copy_from_slice(&hand.posture_for(&pose).unwrap().q);
    }
    q
}

#[test]
fn teleoperated_arm_starts_on_its_side() {
    let (left_m, right_m) = ([0.3, 0.15, 0.1], [0.3, -0.15, 0.1]);
    let across = Cause::ACROSS_THE_MIDDLE;
    let (one, both) = (GoalKind::TELEOP, GoalKind::TELEOP_BOTH);
    // Beyond the outer edge of the workspace of the left hand, but still on its side.
    let outside_m = [0.28, 0.34, 0.1];
    for (case, kind, hand, q, expected) in [
        (
            "own sides",
            one,
            Hand::RIGHT,
            postures(left_m, right_m),
            None,
        ),
        (
            "own sides",
            both,
            Hand::RIGHT,
            postures(left_m, right_m),
            None,
        ),
        (
            "other arm across",
            one,
            Hand::RIGHT,
            postures([0.3, -0.02, 0.1], [0.3, -0.25, 0.1]),
            Some((across, 0)),
        ),
        (
            "acting arm across",
            one,
            Hand::RIGHT,
            postures([0.3, 0.25, 0.1], [0.3, 0.02, 0.1]),
            Some((across, 1)),
        ),
        (
            "other arm outside",
            one,
            Hand::RIGHT,
            postures(outside_m, right_m),
            None,
        ),
        (
            "acting arm outside",
            one,
            Hand::LEFT,
            postures(outside_m, right_m),
            Some((across, 0)),
        ),
        (
            "both, one outside",
            both,
            Hand::RIGHT,
            postures(outside_m, right_m),
            Some((across, 0)),
        ),
    ] {
        let request = GoalRequest {
            kind,
            hand,
            helper_width_m: 0.05,
            ..goal()
        };
        assert_eq!(refusal(robot(), &request, Some(&q)), expected, "{case}");
    }
    let request = GoalRequest {
        kind: one,
        hand: Hand::LEFT,
        ..goal()
    };
    let q = postures(outside_m, right_m);
    let reason = check_on(robot(), &request, Some(&q), &Settings::default()).unwrap_err();
    let Reason::AcrossTheMiddle { gap_m, limit_m, .. } = reason else {
        panic!("{reason:?}")
    };
    assert!((gap_m - 0.34).abs() < 1e-6, "{reason:?}");
    assert_eq!(limit_m, 0.11, "inner edge of the workspace");
}

#[test]
fn single_arm_may_be_teleoperated_in_the_middle() {
    let request = GoalRequest {
        kind: GoalKind::TELEOP,
        ..goal()
    };
    let home = home_of(test_bench());
    assert_eq!(refusal(test_bench(), &request, Some(&home)), None);
}

#[test]
fn teleoperation_needs_a_workspace() {
    let request = GoalRequest {
        kind: GoalKind::TELEOP,
        ..goal()
    };
    let home = home_of(angular_jaw());
    assert_eq!(
        refusal(angular_jaw(), &request, Some(&home)),
        Some((Cause::NO_WORKSPACE, 1))
    );
    assert_eq!(
        refusal(angular_jaw(), &request, None),
        None,
        "the tick rejects it until then"
    );
}

#[test]
fn accepted_goal_has_most_of_the_gap_as_margin() {
    let q = postures([0.3, 0.15, 0.1], [0.3, -0.15, 0.1]);
    let request = GoalRequest {
        kind: GoalKind::TELEOP,
        ..goal()
    };
    let accepted = check_on(robot(), &request, Some(&q), &Settings::default()).unwrap();
    let bodies = HandSide::BOTH.map(|side| {
        let hand = robot().hand(side);
        let of_hand = HandVector::from_slice(&q[robot().joint_range(side)]);
        hand.capsules(&hand.forward(&of_hand))
    });
    // The task begins with a small motion, so the margin is a little smaller than at first.
    let most_m = nearest(&bodies[0], &bodies[1]).gap_m - check::CLEARANCE_M;
    let found_m = accepted.clearance_margin_m();
    assert!(
        0.9 * most_m < found_m && found_m <= most_m,
        "{found_m} of {most_m} m"
    );
}
