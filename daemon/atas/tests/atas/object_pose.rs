//! Object pose from tactile contact.

use crate::support::robot;
use atas_core::perception::{ObjectPose, Percept};
use nalgebra::{Rotation2, Vector2, Vector3};
use robot_model::{GraspPose, GraspSide, HandPose, HandSide};

/// Hand with its fingertips on both sides of a point, and a percept without contact.
fn hand() -> (HandPose, Percept) {
    let hand = robot().hand(HandSide::Right);
    let centre_m = Vector3::new(0.32, -0.15, 0.05);
    let yaw_rad = hand.closing_yaw_rad(&centre_m, 0.4);
    let frame = GraspPose::from_above(centre_m, yaw_rad, 0.05);
    let posture = hand.posture_for(&frame).expect("reachable");
    let mut percept = Percept::default();
    for finger in 0..hand.fingertip_count() {
        percept.side_of_fingertip[finger] = hand.grasp_side(finger);
    }
    (hand.forward(&posture.q), percept)
}

/// Estimate from contacts with these face normals, into the object, base frame.
fn estimate(normals: [Vector2<f64>; 2]) -> Option<ObjectPose> {
    let (pose, mut percept) = hand();
    for (finger, normal) in normals.into_iter().enumerate() {
        let tip = &pose.base_from_tip()[finger];
        let measured = &mut percept.fingertips[finger];
        measured.patch_normal = tip.rotation.tr_mul(&Vector3::new(normal.x, normal.y, 0.0));
        (measured.in_contact, measured.normal_n) = (true, 1.0);
    }
    ObjectPose::estimate(robot().hand(HandSide::Right), &pose, &percept)
}

fn tips() -> ([Vector2<f64>; 2], Vector2<f64>, Vector2<f64>) {
    let (pose, _) = hand();
    let tips_m = GraspSide::BOTH.map(|side| pose.side_m(side).xy());
    let way = (tips_m[1] - tips_m[0]).normalize();
    (tips_m, (tips_m[0] + tips_m[1]) / 2.0, way)
}

/// Parallel faces determine the yaw error, but no position along them.
#[test]
fn parallel_faces_give_the_yaw_error() {
    let (_, _, way) = tips();
    for turn_deg in [-20.0, -3.0, 0.0, 7.5, 15.0] {
        let turn_rad = f64::to_radians(turn_deg);
        let normal = Rotation2::new(turn_rad) * way;
        let measured = estimate([normal, -normal]).expect("both sides in contact");
        assert!(
            (measured.yaw_error_rad - turn_rad).abs() < 1e-9,
            "{turn_deg}: {measured:?}"
        );
        // Equal fingertip radii on parallel faces: the contacts and the fingertips have the same
        // middle.
        assert!(measured.offset_m.norm() < 1e-9, "{turn_deg}: {measured:?}");
        assert!(
            (measured.closing_axis + way).norm() < 1e-9,
            "{turn_deg}: {measured:?}"
        );
    }
}

/// The contact normals of a round object intersect on its axis.
#[test]
fn round_object_gives_its_axis_position() {
    let (tips_m, middle_m, way) = tips();
    let across = Vector2::new(-way.y, way.x);
    for off_m in [-0.005, 0.0, 0.001, 0.006] {
        let axis_m = middle_m + across * off_m;
        let measured = estimate(tips_m.map(|tip_m| (axis_m - tip_m).normalize()))
            .expect("both sides in contact");
        assert!(
            (measured.offset_m - across * off_m).norm() < 1e-9,
            "{off_m}: {measured:?}"
        );
        assert!(measured.yaw_error_rad.abs() < 1e-9, "{off_m}: {measured:?}");
    }
}

#[test]
fn one_sided_contact_gives_no_pose() {
    let (pose, mut percept) = hand();
    let model = robot().hand(HandSide::Right);
    assert_eq!(ObjectPose::estimate(model, &pose, &percept), None);
    let first = &mut percept.fingertips[0];
    (first.in_contact, first.normal_n) = (true, 1.0);
    assert_eq!(ObjectPose::estimate(model, &pose, &percept), None);
    let (_, _, way) = tips();
    assert_eq!(
        estimate([way, way]),
        None,
        "normals that do not oppose each other"
    );
    let nan = Vector2::new(f64::NAN, 0.0);
    let strange = estimate([nan, -way]);
    assert!(strange.is_none_or(|measured| !measured.offset_m.norm().is_finite()));
}
