//! Goal check: sides of teleoperated arms, capabilities of the hand, limits of places.

use crate::goal::goal;
use crate::support::{angular_jaw, home_of, robot, test_bench};
use atas_core::check::{self, GoalContext};
use atas_core::{Goal, SensorSetup, Settings};
use nalgebra::Vector3;
use robot_model::{GraspPose, HandSide, HandVector, RobotModel, RobotVector, nearest};
use shm_schemas::{Cause, GoalField, GoalKind, GoalRequest, Hand, Reason, ReasonRecord};

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

fn check_on(
    robot: &RobotModel,
    request: &GoalRequest,
    q: Option<&RobotVector>,
    settings: &Settings,
) -> Result<Goal, Reason> {
    let now = GoalContext {
        robot,
        wiring: &SensorSetup::from_robot(robot),
        settings,
        tasks: &[],
        commanded_position: q,
    };
    check::check(request, &now)
}

/// Cause and index of the refusal; `None` if accepted.
fn refusal(
    robot: &RobotModel,
    request: &GoalRequest,
    q: Option<&RobotVector>,
) -> Option<(Cause, u32)> {
    let refused = check_on(robot, request, q, &Settings::default()).err()?;
    let refused = ReasonRecord::from(refused);
    Some((refused.cause, refused.index))
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
fn hand_must_be_able_to_turn_caps() {
    let on_bench = |kind| GoalRequest {
        kind,
        from_m: [0.3, 0.0, 0.1],
        from_yaw_rad: core::f64::consts::FRAC_PI_2,
        ..goal()
    };
    let grasp = on_bench(GoalKind::GRASP);
    assert_eq!(refusal(test_bench(), &grasp, None), None);
    let screw = on_bench(GoalKind::SCREW);
    assert_eq!(
        refusal(test_bench(), &screw, None),
        Some((Cause::CANNOT_TURN, 1))
    );
    let screw = GoalRequest {
        kind: GoalKind::SCREW,
        ..goal()
    };
    assert_eq!(refusal(robot(), &screw, None), None);
}

#[test]
fn width_of_the_helping_hand_is_checked_for_either_side() {
    let assemble = |hand, y_m: f64, helper_width_m| GoalRequest {
        kind: GoalKind::ASSEMBLE,
        hand,
        from_m: [0.3, y_m, 0.05],
        to_m: [0.3, y_m / 2.0, 0.12],
        width_m: 0.03,
        helper_width_m,
        ..goal()
    };
    for (hand, y_m) in [(Hand::RIGHT, -0.1), (Hand::LEFT, 0.1)] {
        for (helper_width_m, expected) in [
            (0.06, None),
            (0.11, None),
            (0.02, None),
            (0.111, Some((Cause::OUT_OF_RANGE, 11))),
            (0.019, Some((Cause::OUT_OF_RANGE, 11))),
        ] {
            let request = assemble(hand, y_m, helper_width_m);
            assert_eq!(
                refusal(robot(), &request, None),
                expected,
                "{helper_width_m} m"
            );
        }
    }
}

#[test]
fn refusal_names_the_violated_limit() {
    type Change = fn(&mut GoalRequest);
    let rows: [(Change, Cause, u32, f64); 12] = [
        (
            |g| g.from_yaw_rad = -6.3,
            Cause::OUT_OF_RANGE,
            3,
            -core::f64::consts::TAU,
        ),
        (
            |g| g.from_yaw_rad = 6.3,
            Cause::OUT_OF_RANGE,
            3,
            core::f64::consts::TAU,
        ),
        (
            |g| g.to_yaw_rad = -6.3,
            Cause::OUT_OF_RANGE,
            7,
            -core::f64::consts::TAU,
        ),
        (
            |g| g.to_yaw_rad = 6.3,
            Cause::OUT_OF_RANGE,
            7,
            core::f64::consts::TAU,
        ),
        (|g| g.lift_m = -0.01, Cause::OUT_OF_RANGE, 9, 0.0),
        (|g| g.lift_m = 0.16, Cause::OUT_OF_RANGE, 9, 0.15),
        (|g| g.from_m[0] = 0.219_998, Cause::UNREACHABLE, 0, 0.22),
        (|g| g.from_m[0] = 0.400_002, Cause::UNREACHABLE, 0, 0.4),
        (|g| g.from_m[1] = -0.300_002, Cause::UNREACHABLE, 1, -0.3),
        (|g| g.from_m[1] = 0.060_002, Cause::UNREACHABLE, 1, 0.06),
        (|g| g.from_m[2] = 0.024_998, Cause::UNREACHABLE, 2, 0.025),
        (|g| g.width_m = 0.019_998, Cause::UNREACHABLE, 8, 0.02),
    ];
    for (change, cause, index, limit) in rows {
        let mut request = goal();
        change(&mut request);
        let reason = check_on(robot(), &request, None, &Settings::default()).unwrap_err();
        let reason = ReasonRecord::from(reason);
        assert_eq!(
            (reason.cause, reason.index, reason.limit),
            (cause, index, limit),
            "{request:?}"
        );
    }
}

#[test]
fn limits_themselves_are_accepted() {
    type Change = fn(&mut GoalRequest);
    let rows: [Change; 10] = [
        |g| g.from_yaw_rad = -core::f64::consts::TAU,
        |g| g.to_yaw_rad = core::f64::consts::TAU,
        |g| g.lift_m = 0.15,
        |g| g.hold_s = 3600.0,
        // Rounding errors of decimal sums.
        |g| g.from_m[0] = 0.22 - 0.9e-6,
        |g| g.from_m[0] = 0.4 + 0.9e-6,
        |g| g.from_m[2] = 0.025 - 0.9e-6,
        |g| g.width_m = 0.02 - 0.9e-6,
        |g| g.max_force_n = 8.0,
        |g| g.max_force_n = Settings::default().grasp.carry_min_n,
    ];
    for change in rows {
        let mut request = goal();
        change(&mut request);
        assert_eq!(refusal(robot(), &request, None), None, "{request:?}");
    }
}

/// The palm must stay above the object, and the hand must fit above it before it descends.
#[test]
fn object_must_fit_below_the_palm() {
    let at_m = [0.3, -0.1, 0.05];
    let hand = robot().hand(HandSide::Right);
    let centre_m = Vector3::from(at_m);
    let yaw_rad = hand.closing_yaw_rad(&centre_m, 0.0);
    let grasp = hand
        .posture_for(&GraspPose::from_above(centre_m, yaw_rad, 0.05))
        .unwrap();
    // Clearance above the object: 10 mm.
    let room_m = hand.lowest_of_palm_m(&hand.forward(&grasp.q)) - at_m[2] - 0.01;
    let refused = |top_m: f64| {
        let request = GoalRequest {
            from_m: at_m,
            lift_m: 0.01,
            top_m,
            ..goal()
        };
        check_on(robot(), &request, None, &Settings::default()).err()
    };
    assert_eq!(refused(0.0), None, "height unknown");
    assert_eq!(refused(room_m - 1e-9), None);
    let reason = refused(room_m + 1e-9).expect("too high");
    let Reason::OutOfRange { field, limit, .. } = reason else {
        panic!("{reason:?}")
    };
    assert_eq!(field, GoalField::TOP);
    assert!((limit - room_m).abs() < 1e-9, "{reason:?}");
}

/// Approach heights, of 55, at which the hand fits above an object at this place.
fn heights_accepted(at_m: [f64; 3]) -> u32 {
    let hand = robot().hand(HandSide::Right);
    let request = GoalRequest {
        from_m: at_m,
        lift_m: 0.0,
        top_m: 0.02,
        ..goal()
    };
    let mut accepted = 0;
    for centimetres in 5..60_u32 {
        let mut settings = Settings::default();
        settings.motion.descend_m = f64::from(centimetres) * 0.01;
        let above_m = Vector3::new(at_m[0], at_m[1], at_m[2] + settings.motion.descend_m);
        let yaw_rad = hand.closing_yaw_rad(&above_m, 0.0);
        let above = hand.posture_for(&GraspPose::from_above(above_m, yaw_rad, 0.05));
        let found = check_on(robot(), &request, None, &settings).err();
        let index = found.map(|reason| ReasonRecord::from(reason).index);
        let expected = above.err().map(|_| GoalField::TOP.0);
        assert_eq!(index, expected, "{centimetres} cm above {at_m:?}");
        accepted += u32::from(expected.is_none());
    }
    accepted
}

#[test]
fn hand_must_fit_above_the_object() {
    let high = heights_accepted([0.4, -0.3, 0.2]);
    let low = heights_accepted([0.3, -0.1, 0.03]);
    assert!(
        5 < high && high < 50 && high < low,
        "{high} and {low} of 55 heights"
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

/// The search takes steps of 5° to both sides.
#[test]
fn refused_yaw_names_the_nearest_possible_one() {
    let refused = |yaw_rad: f64| {
        let request = GoalRequest {
            from_m: [0.21, 0.0, 0.035],
            from_yaw_rad: yaw_rad,
            width_m: 0.05,
            lift_m: 0.04,
            ..goal()
        };
        check_on(angular_jaw(), &request, None, &Settings::default()).err()
    };
    for yaw_deg in [30.0_f64, 60.0, 120.0] {
        let yaw_rad = yaw_deg.to_radians();
        let reason = refused(yaw_rad).expect("the hand tilts only in the plane of its arm");
        let Reason::Unreachable {
            field,
            value,
            limit,
        } = reason
        else {
            panic!("{reason:?}")
        };
        assert_eq!((field, value), (GoalField::FROM_YAW, yaw_rad));
        let steps = (1..=18).flat_map(|step| [f64::from(step), -f64::from(step)]);
        let mut yaws_rad = steps.map(|step| yaw_rad + step * 5.0_f64.to_radians());
        let nearest_rad = yaws_rad.find(|yaw_rad| refused(*yaw_rad).is_none());
        let nearest_rad = nearest_rad.expect("a possible yaw");
        assert!((limit - nearest_rad).abs() < 1e-9, "{yaw_deg}°: {reason}");
    }
}

/// The release opens the jaw by 30 mm, and its domes tilt as it opens. Fully open, it does not fit.
#[test]
fn tilting_hand_must_fit_while_released() {
    let hand = angular_jaw().hand(HandSide::Right);
    let at_m = [0.18, 0.0, 0.135];
    let centre_m = Vector3::from(at_m);
    let yaw_rad = hand.closing_yaw_rad(&centre_m, 0.0);
    let fits = |opening_m: f64| {
        let open = GraspPose::from_above(centre_m, yaw_rad, opening_m);
        hand.posture_for(&open).is_ok()
    };
    assert!(!fits(hand.max_opening_m()));
    let mut accepted = 0;
    for millimetres in 25..46_u32 {
        let width_m = f64::from(millimetres) * 1e-3;
        let request = GoalRequest {
            from_m: at_m,
            width_m,
            lift_m: 0.0,
            ..goal()
        };
        let found = refusal(angular_jaw(), &request, None);
        let expected = fits(width_m + 0.03);
        assert_eq!(found.is_none(), expected, "{millimetres} mm");
        accepted += u32::from(expected);
    }
    assert!(5 < accepted && accepted < 16, "{accepted} of 21 widths");
}
