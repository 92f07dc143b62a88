//! Skeleton for viewers: equals the kinematics of the controller.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use robot_model::{HandSide, Placement, RobotVector, SHIPPED, Skeleton, TWO_HAND_ARM};

use crate::support::{ROBOT, between_limits, fractions};

fn isometry(placement: &Placement) -> Isometry3<f64> {
    let [x, y, z, w] = placement.rotation_xyzw;
    Isometry3::from_parts(
        Translation3::from(Vector3::from(placement.translation_m)),
        UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
    )
}

/// Returns the pose of each link in the base frame.
fn placed(skeleton: &Skeleton, q: &[f64]) -> Vec<Isometry3<f64>> {
    let mut base_from: Vec<Isometry3<f64>> = Vec::new();
    for limb in skeleton.limbs() {
        let parent = limb.parent.map_or(Isometry3::identity(), |p| base_from[p]);
        base_from.push(parent * isometry(&limb.placed(q)));
    }
    base_from
}

proptest! {
    #[test]
    fn fingertips_equal_the_controller_kinematics(at in fractions(), side in 0..2_usize) {
        let side = HandSide::BOTH[side];
        let skeleton = TWO_HAND_ARM.skeleton().expect("it ships");
        let hand = ROBOT.hand(side);
        let q_hand_rad = between_limits(hand, &at);
        let mut q = RobotVector::zeros(ROBOT.joint_count());
        q[ROBOT.joint_range(side)].copy_from_slice(&q_hand_rad);
        let base_from = placed(&skeleton, &q);
        let pose = hand.forward(&q_hand_rad);
        for (finger, name) in hand.tip_links().enumerate() {
            let index = skeleton.limbs().iter().position(|limb| limb.name == name).expect("a tip");
            let tip = pose.base_from_tip()[finger];
            let found = &base_from[index];
            prop_assert!((found.translation.vector - tip.translation_m).norm() < 1e-9);
            prop_assert!((found.rotation.to_rotation_matrix().matrix() - tip.rotation).norm() < 1e-9);
        }
    }
}

#[test]
fn joints_are_named_in_the_order_of_joint_vectors() {
    for files in SHIPPED {
        let (skeleton, robot) = (
            files.skeleton().expect("it ships"),
            files.load().expect("it ships"),
        );
        let names: Vec<&str> = robot.joints().map(|joint| joint.name.as_str()).collect();
        assert_eq!(skeleton.joint_names(), names);
        let shapes: usize = skeleton.limbs().iter().map(|limb| limb.shapes.len()).sum();
        assert_eq!(shapes, files.urdf.matches("<visual>").count());
    }
}

#[test]
fn mimicking_jaw_follows_its_master() {
    for files in SHIPPED {
        let (skeleton, robot) = (
            files.skeleton().expect("it ships"),
            files.load().expect("it ships"),
        );
        let hand = robot.hand(robot.acting_side());
        let mut q = RobotVector::zeros(robot.joint_count());
        q[robot.joint_range(hand.side())].copy_from_slice(hand.reference());
        let base_from = placed(&skeleton, &q);
        let pose = hand.forward(hand.reference());
        for (finger, name) in hand.tip_links().enumerate() {
            let index = skeleton
                .limbs()
                .iter()
                .position(|limb| limb.name == name)
                .expect("a tip");
            let off_m = base_from[index].translation.vector - pose.tip_m(finger);
            assert!(off_m.norm() < 1e-9, "{} {name}: {off_m}", files.name);
        }
    }
}

#[test]
fn links_without_tree_are_rejected_by_name() {
    let check = |body: &str, part: &str| {
        let text = format!("<robot name=\"r\">{body}</robot>");
        let error = Skeleton::read(&text, vec!["j".into(), "k".into()]);
        let error = error.expect_err(body).to_string();
        assert!(error.contains(part), "{error}");
    };
    let links = "<link name=\"a\"/><link name=\"b\"/>";
    let joint = |name: &str, parent: &str, child: &str, axis: &str| {
        format!(
            "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <axis xyz=\"{axis}\"/><limit lower=\"0\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint>"
        )
    };
    let circle = [joint("j", "a", "b", "0 0 1"), joint("k", "b", "a", "0 0 1")].concat();
    check(&format!("{links}{circle}"), "a tree of links");
    check(
        &format!("{links}{}", joint("j", "a", "c", "0 0 1")),
        "link `c` was missing",
    );
    check(
        &format!("{links}{}", joint("j", "a", "b", "0 0 0")),
        "the axis of joint `j`",
    );
    let twice = [joint("j", "a", "b", "0 0 1"), joint("k", "a", "b", "0 0 1")].concat();
    check(&format!("{links}{twice}"), "a tree of links");
}
