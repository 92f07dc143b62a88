//! Workspace: every grasp of a grid has a posture.

use nalgebra::Vector3;
use robot_model::{GraspPose, HandSide, HandVector, Workspace};

use crate::support::ROBOT;

/// `count` values from the first to the last.
fn spread([from, to]: [f64; 2], count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |index| from + (to - from) * index as f64 / (count - 1) as f64)
}

/// All grasps of a grid over the workspace of one side; twelve yaws cover every direction of the
/// closing axis.
fn grasps(side: HandSide) -> impl Iterator<Item = GraspPose> {
    let Workspace {
        x_m,
        y_m,
        z_m,
        opening_m,
    } = *ROBOT
        .hand(side)
        .workspace()
        .expect("its robot file has one");
    spread(x_m, 4).flat_map(move |x| {
        spread(y_m, 5).flat_map(move |y| {
            spread(z_m, 4).flat_map(move |z| {
                spread(opening_m, 4).flat_map(move |opening| {
                    spread([0.0, 165_f64.to_radians()], 12).map(move |yaw| {
                        let centre_m = Vector3::new(x, y, z);
                        let yaw = ROBOT.hand(side).closing_yaw_rad(&centre_m, yaw);
                        GraspPose::from_above(centre_m, yaw, opening)
                    })
                })
            })
        })
    })
}

#[test]
fn every_grasp_of_the_workspace_has_a_posture() {
    for side in HandSide::BOTH {
        let hand = ROBOT.hand(side);
        for grasp in grasps(side) {
            let found = hand
                .posture_for(&grasp)
                .unwrap_or_else(|error| panic!("{side:?} {grasp:?}: {error}"));
            assert!(
                found.tip_error_m < 1e-6,
                "{side:?} {grasp:?}: tip {} m off",
                found.tip_error_m
            );
            assert!(
                found.dome_error_rad < 0.1_f64.to_radians(),
                "{side:?} {grasp:?}: dome {}",
                found.dome_error_rad
            );
            assert!(hand.within_limits(&found.q), "{side:?} {grasp:?}");
            let roll_deg = found.q[4].to_degrees();
            assert!(
                roll_deg.abs() <= 95.0,
                "{side:?} {grasp:?}: wrist roll {roll_deg}°"
            );
        }
    }
}

#[test]
fn closing_yaw_keeps_the_object_and_the_wrist_roll_within_a_right_angle() {
    for side in HandSide::BOTH {
        let hand = ROBOT.hand(side);
        let centre_m = Vector3::new(0.3, -0.1 * side.y_sign(), 0.1);
        for yaw in spread([-7.0, 7.0], 57) {
            let chosen = hand.closing_yaw_rad(&centre_m, yaw);
            assert!(
                ((chosen - yaw) / std::f64::consts::PI).fract().abs() < 1e-12,
                "another closing line"
            );
            let roll = hand.bearing_rad(&centre_m) + std::f64::consts::FRAC_PI_2 - chosen;
            assert!(
                roll.cos() > -1e-12,
                "{side:?}: wrist roll {roll} rad for yaw {yaw}"
            );
        }
    }
}

#[test]
fn unreachable_grasp_reports_its_distance() {
    let grasp = GraspPose::from_above(Vector3::new(0.9, -0.2, 0.1), 1.5, 0.06);
    let error = ROBOT
        .hand(HandSide::Right)
        .posture_for(&grasp)
        .expect_err("0.9 m is out of reach");
    assert!(
        error.best.tip_error_m > 0.05
            && error
                .to_string()
                .starts_with("could not reach the grasp because")
    );
}

#[test]
fn a_grasp_that_is_not_finite_has_no_posture() {
    let hand = ROBOT.hand(HandSide::Left);
    for bad in [f64::NAN, f64::INFINITY] {
        let grasp = GraspPose::from_above(Vector3::new(0.3, bad, 0.1), 1.5, 0.06);
        let error = hand.posture_for(&grasp).expect_err("not a place");
        assert_eq!(error.best.tip_error_m, f64::INFINITY);
        assert!(hand.within_limits(&error.best.q));
    }
}

#[test]
fn clamping_leaves_only_usable_angles() {
    let hand = ROBOT.hand(HandSide::Right);
    let mut q = HandVector::repeat(11, 100.0);
    q[3] = f64::NAN;
    let clamped = hand.clamp_to_limits(&q);
    assert!(hand.within_limits(&clamped));
    assert_eq!(clamped[3], hand.reference()[3]);
}
