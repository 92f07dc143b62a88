//! The proved workspace: every grasp of a grid has a posture; what is outside is refused by name.

use nalgebra::Vector3;
use robot_model::{GraspFrame, HandVector, Side, Workspace};

use crate::support::ROBOT;

/// `count` values from the first to the last.
fn spread([from, to]: [f64; 2], count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |index| from + (to - from) * index as f64 / (count - 1) as f64)
}

/// All grasps of a grid over the workspace of one side; twelve yaws cover every direction of the closing axis.
fn grasps(side: Side) -> impl Iterator<Item = GraspFrame> {
    let Workspace {
        x_m,
        right_y_m,
        z_m,
        opening_m,
    } = Workspace::TWO_HAND_ARM;
    spread(x_m, 4).flat_map(move |x| {
        spread(right_y_m, 5).flat_map(move |y| {
            spread(z_m, 4).flat_map(move |z| {
                spread(opening_m, 4).flat_map(move |opening| {
                    spread([0.0, 165_f64.to_radians()], 12).map(move |yaw| {
                        let centre_m = Vector3::new(x, -side.y_sign() * y, z);
                        let yaw = ROBOT.hand(side).closing_yaw_rad(&centre_m, yaw);
                        GraspFrame::from_above(centre_m, yaw, opening)
                    })
                })
            })
        })
    })
}

#[test]
fn every_grasp_of_the_workspace_has_a_posture() {
    for side in Side::BOTH {
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
            assert!(hand.within_limits(&found.q_rad), "{side:?} {grasp:?}");
            let roll_deg = found.q_rad[4].to_degrees();
            assert!(
                roll_deg.abs() <= 95.0,
                "{side:?} {grasp:?}: wrist roll {roll_deg}°"
            );
        }
    }
}

#[test]
fn closing_yaw_keeps_the_object_and_the_wrist_roll_within_a_right_angle() {
    for side in Side::BOTH {
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
fn reach_names_what_is_outside() {
    let inside = [0.3, -0.1, 0.1, 0.06];
    let check = |side: Side, [x, y, z, opening]: [f64; 4], wanted: Option<&str>| {
        let is = Workspace::TWO_HAND_ARM
            .reach(side, &Vector3::new(x, y, z), opening)
            .err();
        let is = is.map(|error| error.to_string());
        match wanted {
            None => assert_eq!(is, None),
            Some(part) => assert!(
                is.as_ref().is_some_and(|text| text.contains(part)),
                "{is:?} lacks {part}"
            ),
        }
    };
    check(Side::Right, inside, None);
    check(Side::Left, [0.3, 0.1, 0.1, 0.06], None);
    check(Side::Right, [0.22, 0.06, 0.025, 0.02], None);
    check(
        Side::Right,
        [0.21, -0.1, 0.1, 0.06],
        Some("Right hand's grasp because x of the grasp was 0.21 m, needs 0.22 to 0.4"),
    );
    check(
        Side::Left,
        inside,
        Some("y of the grasp was -0.1 m, needs -0.06 to 0.3"),
    );
    check(
        Side::Right,
        [0.3, -0.1, 0.016, 0.06],
        Some("height of the grasp was 0.016 m, needs 0.025 to 0.21"),
    );
    check(
        Side::Right,
        [0.3, -0.1, 0.1, 0.12],
        Some("opening was 0.12 m, needs 0.02 to 0.11"),
    );
    check(
        Side::Right,
        [f64::NAN, -0.1, 0.1, 0.06],
        Some("x of the grasp was NaN"),
    );
    check(
        Side::Right,
        [0.3, -0.1, 0.1, f64::INFINITY],
        Some("opening was inf"),
    );
}

#[test]
fn an_unreachable_grasp_says_how_far_it_is() {
    let grasp = GraspFrame::from_above(Vector3::new(0.9, -0.2, 0.1), 1.5, 0.06);
    let error = ROBOT
        .hand(Side::Right)
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
    let hand = ROBOT.hand(Side::Left);
    for bad in [f64::NAN, f64::INFINITY] {
        let grasp = GraspFrame::from_above(Vector3::new(0.3, bad, 0.1), 1.5, 0.06);
        let error = hand.posture_for(&grasp).expect_err("not a place");
        assert_eq!(error.best.tip_error_m, f64::INFINITY);
        assert!(hand.within_limits(&error.best.q_rad));
    }
}

#[test]
fn clamping_leaves_only_usable_angles() {
    let hand = ROBOT.hand(Side::Right);
    let mut q = HandVector::repeat(11, 100.0);
    q[3] = f64::NAN;
    let clamped = hand.clamp_to_limits(&q);
    assert!(hand.within_limits(&clamped));
    assert_eq!(clamped[3], hand.reference_rad()[3]);
}
