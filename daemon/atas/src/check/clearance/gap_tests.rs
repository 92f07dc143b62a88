//! Tests of the gap between the arms and of the samples of a path.

use super::*;
use nalgebra::Vector3;
use robot_model::RobotModel;

/// Bodies of both arms at home, the acting right arm first, and their gap, m.
fn at_home(robot: &RobotModel) -> ([Sample; 2], f64) {
    let samples = [HandSide::Right, HandSide::Left].map(|side| sample(robot, side, 1.0));
    let gap_m = nearest(&samples[0].bodies, &samples[1].bodies).gap_m;
    (samples, gap_m)
}

/// Bodies of one arm at its reference posture, multiplied by a factor.
fn sample(robot: &RobotModel, side: HandSide, factor: f64) -> Sample {
    let hand = robot.hand(side);
    let centre_m = Vector3::new(0.3, 0.2 * side.y_sign(), 0.1);
    let pose = GraspPose::from_above(centre_m, hand.closing_yaw_rad(&centre_m, 0.0), 0.05);
    let q = hand.posture_for(&pose).expect("a posture").q * factor;
    Sample {
        bodies: hand.capsules(&hand.forward(&q)),
        uncertainty_m: 0.0,
        at_target: false,
    }
}

fn gap(initial_limit_m: Option<f64>, both_hands: bool) -> Gap {
    Gap {
        hands: [1, 0],
        initial_limit_m: Cell::new(initial_limit_m),
        both_hands,
        narrowest_m: Cell::new(1.0),
    }
}

#[test]
fn gap_below_its_limit_is_refused() {
    let robot = RobotModel::two_hand_arm().expect("built in");
    let ([mut ours, mut theirs], free_m) = at_home(&robot);
    assert!(free_m > 0.05, "{free_m} m");
    for (initial_limit_m, left_m, is_accepted) in [
        (None, 0.0081, true),
        (None, 0.0079, false),
        (None, -0.1, false),
        (Some(0.003), 0.0031, true),
        (Some(0.003), 0.0029, false),
        (Some(f64::NEG_INFINITY), -0.1, true),
    ] {
        let gap = gap(initial_limit_m, false);
        for share in [0.0, 0.3, 1.0] {
            ours.uncertainty_m = (free_m - left_m) * share;
            theirs.uncertainty_m = (free_m - left_m) * (1.0 - share);
            let result = gap.check(&ours, &theirs);
            assert_eq!(
                result.is_ok(),
                is_accepted,
                "{left_m} m of {initial_limit_m:?}"
            );
            let Err(reason) = result else { continue };
            let Reason::ArmsCollide { gap_m, limit_m, .. } = reason else {
                panic!("{reason:?}")
            };
            assert!((gap_m - left_m).abs() < 1e-9, "{reason:?}");
            assert_eq!(limit_m, initial_limit_m.unwrap_or(CLEARANCE_M));
        }
        assert!((gap.narrowest_m.get() - left_m).abs() < 1e-9);
    }
}

/// Arms that start too close may only separate.
#[test]
fn initial_limit_ends_with_the_first_clearance() {
    let robot = RobotModel::two_hand_arm().expect("built in");
    let ([mut ours, theirs], free_m) = at_home(&robot);
    let gap = gap(Some(0.002), false);
    for (left_m, is_accepted) in [(0.004, true), (0.0081, true), (0.004, false)] {
        ours.uncertainty_m = free_m - left_m;
        assert_eq!(gap.check(&ours, &theirs).is_ok(), is_accepted, "{left_m} m");
    }
}

#[test]
fn undefined_posture_is_refused() {
    let robot = RobotModel::two_hand_arm().expect("built in");
    let ([_, theirs], _) = at_home(&robot);
    let undefined = sample(&robot, HandSide::Right, f64::NAN);
    for initial_limit_m in [None, Some(f64::NEG_INFINITY)] {
        let gap = gap(initial_limit_m, false);
        assert!(
            gap.check(&undefined, &theirs).is_err(),
            "{initial_limit_m:?}"
        );
    }
}

/// At the target of a task for both hands, the arms are close by intention.
#[test]
fn margin_is_the_narrowest_gap_before_the_target() {
    let robot = RobotModel::two_hand_arm().expect("built in");
    let ([mut ours, theirs], free_m) = at_home(&robot);
    for (both_hands, at_target, margin_m) in [
        (false, false, 0.02),
        (false, true, 0.02),
        (true, false, 0.01),
        (true, true, (1.0 - CLEARANCE_M) / 2.0),
    ] {
        let gap = gap(None, both_hands);
        for left_m in [0.04, CLEARANCE_M + 0.02, 0.05] {
            ours.uncertainty_m = free_m - left_m;
            ours.at_target = at_target;
            assert!(gap.check(&ours, &theirs).is_ok());
        }
        let found_m = gap.clearance_margin_m();
        assert!(
            (found_m - margin_m).abs() < 1e-9,
            "{both_hands}, {at_target}: {found_m} m"
        );
    }
    for (narrowest_m, margin_m) in [(f64::INFINITY, 1.0), (0.001, 0.0)] {
        let gap = gap(None, false);
        gap.narrowest_m.set(narrowest_m);
        assert_eq!(gap.clearance_margin_m(), margin_m);
    }
}

#[test]
fn samples_are_counted_by_the_largest_motion() {
    let mut from = GraspPose::from_above(Vector3::new(0.3, 0.1, 0.2), 0.3, 0.06);
    from.hand_azimuth_rad = 0.5;
    from.root_rad = 0.25;
    from.tangential_m = PerSide::new(0.01, -0.02);
    from.up_m = PerSide::new(0.015, 0.025);
    type Change = fn(&mut GraspPose, f64);
    let turns: [Change; 4] = [
        |pose, by_rad| pose.closing_yaw_rad += by_rad,
        |pose, by_rad| pose.hand_azimuth_rad += by_rad,
        |pose, by_rad| pose.hand_pitch_rad += by_rad,
        |pose, by_rad| pose.root_rad += by_rad,
    ];
    let ways: [Change; 6] = [
        |pose, by_m| pose.half_opening_m[GraspSide::First] += by_m,
        |pose, by_m| pose.half_opening_m[GraspSide::Second] += by_m,
        |pose, by_m| pose.tangential_m[GraspSide::First] += by_m,
        |pose, by_m| pose.up_m[GraspSide::Second] += by_m,
        |pose, by_m| pose.centre_m.x += by_m,
        |pose, by_m| pose.centre_m.z += by_m,
    ];
    assert_eq!(sample_count(&from, &from), 1, "at rest");
    let changes = turns.map(|turn| (turn, 0.02)).into_iter();
    for (index, (change, unit)) in changes.chain(ways.map(|way| (way, 0.004))).enumerate() {
        for (by, expected) in [(0.9, 1), (2.5, 3), (-2.5, 3), (9.5, 10), (-30.5, 31)] {
            let mut to = from;
            change(&mut to, by * unit);
            assert_eq!(sample_count(&from, &to), expected, "change {index} by {by}");
        }
    }
}
