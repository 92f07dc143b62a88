//! Paths: rest to rest, within speed limits, shortest rotation.

use crate::support::robot;
use atas_core::path::{Path, Speeds, reachable_yaw_rad};
use nalgebra::Vector3;
use proptest::prelude::*;
use robot_model::{GraspPose, GraspSide, HandSide};

const SPEEDS: Speeds = Speeds {
    move_m_s: 0.12,
    turn_rad_s: 0.8,
    open_m_s: 0.05,
    wrist_turn_radius_m: None,
};
/// Ratio of peak to mean speed of a minimum-jerk profile.
const PEAK: f64 = 1.875;

fn any_frame() -> impl Strategy<Value = GraspPose> {
    (
        prop::array::uniform3(-0.3..0.3),
        prop::array::uniform4(-2.0..2.0),
        prop::array::uniform6(-0.05..0.05),
    )
        .prop_map(
            |(centre, [yaw, azimuth, pitch, root], [h1, h2, t1, t2, u1, u2])| GraspPose {
                centre_m: Vector3::from(centre),
                closing_yaw_rad: yaw,
                hand_azimuth_rad: azimuth,
                hand_pitch_rad: pitch,
                root_rad: root,
                half_opening_m: [h1, h2].into(),
                tangential_m: [t1, t2].into(),
                up_m: [u1, u2].into(),
            },
        )
}

/// Coordinates with their largest mean speeds.
fn coordinates(f: &GraspPose) -> [(f64, f64); 8] {
    let (turn, open) = (SPEEDS.turn_rad_s, SPEEDS.open_m_s);
    [
        (f.closing_yaw_rad, turn),
        (f.hand_azimuth_rad, turn),
        (f.hand_pitch_rad, turn),
        (f.root_rad, turn),
        (f.half_opening_m[GraspSide::First], open),
        (f.half_opening_m[GraspSide::Second], open),
        (f.tangential_m[GraspSide::First], open),
        (f.tangential_m[GraspSide::Second], open),
    ]
}

proptest! {
    #[test]
    fn path_is_rest_to_rest_within_speed_limits(from in any_frame(), to in any_frame()) {
        let path = Path::free(from, to, &SPEEDS);
        prop_assert_eq!((path.pose_at(0.0), path.pose_at(path.duration_s()), path.pose_at(1e9)), (from, to, to));
        prop_assert_eq!(*path.end(), to);
        let step_s = path.duration_s() / 200.0;
        for i in 0..200 {
            let (a, b) = (path.pose_at(f64::from(i) * step_s), path.pose_at(f64::from(i + 1) * step_s));
            let at_rest = if i == 0 || i == 199 { 0.01 } else { 1.0 };
            prop_assert!((b.centre_m - a.centre_m).norm() <= PEAK * SPEEDS.move_m_s * step_s * at_rest * 1.001 + 1e-12);
            for ((before, speed), (after, _)) in coordinates(&a).into_iter().zip(coordinates(&b)) {
                prop_assert!((after - before).abs() <= PEAK * speed * step_s * at_rest * 1.001 + 1e-12);
            }
        }
    }

    #[test]
    fn every_coordinate_is_monotonic(from in any_frame(), to in any_frame()) {
        let path = Path::free(from, to, &SPEEDS);
        let rows: Vec<_> = (0..=100).map(|i| coordinates(&path.pose_at(path.duration_s() * f64::from(i) / 100.0))).collect();
        for c in 0..8 {
            let upwards = rows[100][c].0 >= rows[0][c].0;
            for pair in rows.windows(2) {
                let (before, after) = (pair[0][c].0, pair[1][c].0);
                let onwards = if upwards { after - before } else { before - after };
                prop_assert!(onwards >= -1e-12);
            }
        }
    }

    /// Obstacles below the higher end of the path are not touched.
    #[test]
    fn path_over_obstacles_crosses_at_higher_end(from in any_frame(), to in any_frame()) {
        let path = Path::over_obstacles(from, to, &SPEEDS);
        prop_assert_eq!((path.pose_at(0.0), path.pose_at(path.duration_s()), *path.end()), (from, to, to));
        let highest_m = from.centre_m.z.max(to.centre_m.z);
        let across_m = |a: &GraspPose, b: &GraspPose| (a.centre_m - b.centre_m).xy().norm();
        let step_s = path.duration_s() / 400.0;
        for i in 0..400 {
            let (a, b) = (path.pose_at(f64::from(i) * step_s), path.pose_at(f64::from(i + 1) * step_s));
            prop_assert!((b.centre_m - a.centre_m).norm() <= PEAK * SPEEDS.move_m_s * step_s * 1.001 + 1e-12);
            let stands_over = across_m(&b, &from).min(across_m(&b, &to)) < 1e-12;
            prop_assert!(stands_over || b.centre_m.z > highest_m - 0.001, "{} m below", highest_m - b.centre_m.z);
        }
    }

    #[test]
    fn gripping_path_keeps_the_opening(from in any_frame(), to in any_frame()) {
        let path = Path::gripping(from, to, &SPEEDS);
        prop_assert!(!path.moves_fingers() && Path::free(from, to, &SPEEDS).moves_fingers());
        prop_assert_eq!(path.pose_at(path.duration_s() / 3.0).half_opening_m, from.half_opening_m);
        prop_assert_eq!(path.end().centre_m, to.centre_m);
    }

    /// The chosen yaw gives an equivalent grasp, needs at most a quarter turn of the wrist, and
    /// does not wind up.
    #[test]
    fn reachable_yaw_is_equivalent(
        yaw_rad in -6.3..6.3, from_yaw_rad in -1.5..1.5, x in 0.22..0.4, y in -0.3..0.06, from_y in -0.3..0.06,
    ) {
        let hand = robot().hand(HandSide::Right);
        let centre_m = Vector3::new(x, y, 0.1);
        let from_m = Vector3::new(0.3, from_y, 0.1);
        let from_yaw_rad = hand.closing_yaw_rad(&from_m, from_yaw_rad);
        let from = GraspPose::from_above(from_m, from_yaw_rad, 0.05);
        let chosen_rad = reachable_yaw_rad(hand, &from, &centre_m, yaw_rad);
        let half_turns = (chosen_rad - yaw_rad) / std::f64::consts::PI;
        prop_assert!((half_turns - half_turns.round()).abs() < 1e-9);
        let roll_rad = |yaw_rad: f64, at_m: &Vector3<f64>| hand.bearing_rad(at_m) + std::f64::consts::FRAC_PI_2 - yaw_rad;
        let turn_rad = roll_rad(chosen_rad, &centre_m) - roll_rad(from_yaw_rad, &from_m);
        prop_assert!(turn_rad.abs() <= std::f64::consts::PI + 1e-9, "wrist rotation {turn_rad} rad");
    }
}

#[test]
fn slowest_coordinate_determines_the_duration() {
    let from = GraspPose::from_above(Vector3::new(0.3, 0.0, 0.1), 0.0, 0.05);
    let far = GraspPose {
        centre_m: Vector3::new(0.3, 0.24, 0.1),
        ..from
    };
    let turned = GraspPose {
        closing_yaw_rad: -1.6,
        ..from
    };
    let open = GraspPose {
        half_opening_m: [0.05, 0.025].into(),
        ..from
    };
    for (to, duration_s) in [(from, 0.05), (far, 2.0), (turned, 2.0), (open, 0.5)] {
        assert!((Path::free(from, to, &SPEEDS).duration_s() - duration_s).abs() < 1e-12);
    }
    assert_eq!(Path::stationary(from).pose_at(0.0), from);
}

/// Regression: the wrist turned faster than its joint can, and the arm swung to compensate.
#[test]
fn opposite_slides_by_the_wrist_take_the_time_of_a_turn() {
    let from = GraspPose::from_above(Vector3::new(0.3, 0.0, 0.1), 0.0, 0.05);
    let check =
        |name: &str, radius_m: Option<f64>, yaw_rad: f64, slides_m: [f64; 2], expected_s: f64| {
            let to = GraspPose {
                closing_yaw_rad: yaw_rad,
                tangential_m: slides_m.into(),
                ..from
            };
            let speeds = Speeds {
                wrist_turn_radius_m: radius_m,
                ..SPEEDS
            };
            let duration_s = Path::free(from, to, &speeds).duration_s();
            assert!(
                (duration_s - expected_s).abs() < 1e-9,
                "{name}: {duration_s} s"
            );
        };
    let (wrist, opposite_m) = (Some(0.012), [0.006, -0.006]);
    check("by the fingers", None, 0.0, opposite_m, 0.12);
    check("by the wrist", wrist, 0.0, opposite_m, 0.5 / 0.8);
    check("with a turn", wrist, 0.5, opposite_m, 1.0 / 0.8);
    check("against a turn", wrist, -0.5, opposite_m, 0.05);
    check("both sides alike", wrist, 0.0, [0.006, 0.006], 0.12);
}
