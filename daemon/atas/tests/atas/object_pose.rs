//! Object pose from tactile contact.

use crate::support::robot;
use atas_core::perception::{ObjectPose, Percept};
use nalgebra::{Rotation2, Vector2, Vector3};
use robot_model::{GraspFrame, HandPose, Side};

/// Hand with its fingertips on both sides of a point, and a percept without contact.
fn hand() -> (HandPose, Percept) {
    let hand = robot().hand(Side::Right);
    let centre_m = Vector3::new(0.32, -0.15, 0.05);
    let yaw_rad = hand.closing_yaw_rad(&centre_m, 0.4);
    let frame = GraspFrame::from_above(centre_m, yaw_rad, 0.05);
    let posture = hand.posture_for(&frame).expect("reachable");
    let mut percept = Percept::default();
    for finger in 0..hand.finger_count() {
        percept.presses_from[finger] = hand.virtual_finger(finger);
    }
    (hand.forward(&posture.q_rad), percept)
}

/// Estimate from contacts with these face normals, into the object, base frame.
fn felt(normals: [Vector2<f64>; 2]) -> Option<ObjectPose> {
    let (pose, mut percept) = hand();
    for (finger, normal) in normals.into_iter().enumerate() {
        let tip = &pose.base_from_tip()[finger];
        let felt = &mut percept.fingers[finger];
        felt.patch_normal = tip.rotation.tr_mul(&Vector3::new(normal.x, normal.y, 0.0));
        (felt.in_contact, felt.normal_n) = (true, 1.0);
    }
    ObjectPose::felt(robot().hand(Side::Right), &pose, &percept)
}

fn tips() -> ([Vector2<f64>; 2], Vector2<f64>, Vector2<f64>) {
    let (pose, _) = hand();
    let tips_m = [0, 1].map(|side| pose.side_m(side).xy());
    let way = (tips_m[1] - tips_m[0]).normalize();
    (tips_m, (tips_m[0] + tips_m[1]) / 2.0, way)
}

/// Parallel faces determine the yaw error, but no position along them.
#[test]
fn faces_tell_how_the_object_is_turned() {
    let (_, _, way) = tips();
    for turn_deg in [-20.0, -3.0, 0.0, 7.5, 15.0] {
        let turn_rad = f64::to_radians(turn_deg);
        let normal = Rotation2::new(turn_rad) * way;
        let felt = felt([normal, -normal]).expect("both press");
        assert!(
            (felt.turn_rad - turn_rad).abs() < 1e-9,
            "{turn_deg}: {felt:?}"
        );
        // Equal fingertip radii on parallel faces: the contacts and the fingertips have the same
        // middle.
        assert!(felt.off_m.norm() < 1e-9, "{turn_deg}: {felt:?}");
        assert!(
            (felt.closing_axis + way).norm() < 1e-9,
            "{turn_deg}: {felt:?}"
        );
    }
}

/// The contact normals of a round object intersect on its axis.
#[test]
fn a_round_object_tells_where_its_axis_is() {
    let (tips_m, middle_m, way) = tips();
    let across = Vector2::new(-way.y, way.x);
    for off_m in [-0.005, 0.0, 0.001, 0.006] {
        let axis_m = middle_m + across * off_m;
        let felt = felt(tips_m.map(|tip_m| (axis_m - tip_m).normalize())).expect("both press");
        assert!(
            (felt.off_m - across * off_m).norm() < 1e-9,
            "{off_m}: {felt:?}"
        );
        assert!(felt.turn_rad.abs() < 1e-9, "{off_m}: {felt:?}");
    }
}

#[test]
fn what_does_not_press_from_both_sides_tells_nothing() {
    let (pose, mut percept) = hand();
    let model = robot().hand(Side::Right);
    assert_eq!(ObjectPose::felt(model, &pose, &percept), None);
    let first = &mut percept.fingers[0];
    (first.in_contact, first.normal_n) = (true, 1.0);
    assert_eq!(ObjectPose::felt(model, &pose, &percept), None);
    let (_, _, way) = tips();
    assert_eq!(
        felt([way, way]),
        None,
        "normals that do not face each other"
    );
    let nan = Vector2::new(f64::NAN, 0.0);
    let strange = felt([nan, -way]);
    assert!(strange.is_none_or(|felt| !felt.off_m.norm().is_finite()));
}
