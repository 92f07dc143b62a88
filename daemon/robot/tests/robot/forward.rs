//! Forward kinematics: equals the prototype and an independent computation; conventions of frames.

use std::f64::consts::FRAC_PI_3;

use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use proptest::prelude::*;
use robot_model::{HandSide, HandVector, RobotModel, TWO_HAND_ARM};
use urdf_rs::{JointType, Robot};

use crate::support::{JOINTS, ROBOT, assert_near, between_limits, degrees, fractions, side};

/// Joint angles in degrees, then tips 1 and 2 (m), dome axes 1 and 2, hand axis.
type Row = (HandSide, [f64; JOINTS], [[f64; 3]; 5]);

/// Key poses of the assembly, computed with the Python prototype (numpy), rounded to 1e-9.
const PROTOTYPE_POSES: &[Row] = &[
    (
        HandSide::Left, // home
        [
            0.0, -37.93, 123.21, 5.87, 0.0, 1.92, -36.21, 66.2, 1.92, -36.21, 66.2,
        ],
        [
            [0.260014195, 0.274996348, 0.150012011],
            [0.260014195, 0.165003652, 0.150012011],
            [-9.347e-06, -0.999999985, -0.000174282],
            [-9.347e-06, 0.999999985, -0.000174282],
            [-0.020069939, 0.0, -0.999798578],
        ],
    ),
    (
        HandSide::Left, // insert, hand 45° below the horizontal
        [
            -30.07, 11.8, 80.28, -44.79, 0.0, -27.72, -50.57, 80.54, -27.72, -50.57, 80.54,
        ],
        [
            [0.41255236, 0.056246456, 0.045001822],
            [0.347416931, -0.056253776, 0.045001822],
            [-0.500630654, -0.865660972, -0.000175384],
            [0.501484561, 0.865166576, -0.000175384],
            [0.586999794, -0.339861372, -0.734796223],
        ],
    ),
    (
        HandSide::Right, // cap grasped on the stand
        [
            6.69, -14.52, 97.02, 7.84, 36.68, 1.01, -8.71, 38.52, 1.01, -5.93, 36.14,
        ],
        [
            [0.334784996, -0.15443368, 0.050007615],
            [0.305289572, -0.205533094, 0.049999044],
            [-0.499905816, -0.866079744, 0.00022941],
            [0.499912592, 0.866075854, 0.000119568],
            [-0.005893679, -0.000691305, -0.999982393],
        ],
    ),
    (
        HandSide::Right, // cap turned on the bottle, roots in anti-phase
        [
            30.12, -21.3, 72.98, 38.44, 60.1, 2.71, -8.4, 38.29, -3.71, -6.04, 36.16,
        ],
        [
            [0.388611452, 0.028993725, 0.130008986],
            [0.371334467, -0.028941416, 0.130009107],
            [-0.499777205, -0.86615399, -0.000101995],
            [0.499581327, 0.866266946, 0.000274522],
            [-0.001811601, -0.001050993, -0.999997807],
        ],
    ),
];

#[test]
fn key_poses_equal_the_prototype() {
    for (side, q_deg, wanted) in PROTOTYPE_POSES {
        let pose = ROBOT.hand(*side).forward(&degrees(*q_deg));
        let is = [
            pose.tip_m(0),
            pose.tip_m(1),
            pose.dome_axis(0),
            pose.dome_axis(1),
            pose.hand_axis(),
        ];
        for (is, wanted) in is.into_iter().zip(wanted) {
            assert_near("key pose", is, Vector3::from(*wanted), 1.5e-9);
        }
    }
}

/// Returns the pose of a link from the URDF by quaternions: no code shared with the crate.
fn link_pose(urdf: &Robot, link: &str, angle: &dyn Fn(&str) -> f64) -> Isometry3<f64> {
    let Some(joint) = urdf.joints.iter().find(|joint| joint.child.link == link) else {
        return Isometry3::identity();
    };
    let (xyz, rpy) = (joint.origin.xyz, joint.origin.rpy);
    let origin = Isometry3::from_parts(
        Translation3::new(xyz[0], xyz[1], xyz[2]),
        UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2]),
    );
    let turn = match joint.joint_type {
        JointType::Fixed => UnitQuaternion::identity(),
        _ => UnitQuaternion::from_axis_angle(
            &Unit::new_normalize(Vector3::from(joint.axis.xyz.0)),
            angle(&joint.name),
        ),
    };
    link_pose(urdf, &joint.parent.link, angle) * origin * turn
}

/// Compares tips, tip frames and hand frame of one hand with the independent computation.
fn check_against_urdf(urdf: &Robot, robot: &RobotModel, side: HandSide, q: &HandVector) {
    let hand = robot.hand(side);
    let angle = |name: &str| {
        let mut names = hand.joints().iter().map(|joint| joint.name);
        names
            .position(|known| known == name)
            .map_or(0.0, |index| q[index])
    };
    let pose = hand.forward(q);
    let compare = |link: &str, frame: &robot_model::Transform| {
        let wanted = link_pose(urdf, link, &angle);
        for local in [
            Point3::origin(),
            Point3::new(1.0, 0.0, 0.0),
            Point3::new(0.0, 1.0, 0.0),
        ] {
            assert_near(
                link,
                frame.point(&local.coords),
                (wanted * local).coords,
                1e-12,
            );
        }
    };
    for (link, frame) in hand.tip_links().zip(pose.base_from_tip()) {
        compare(link, frame);
    }
    let wrist_roll = urdf
        .joints
        .iter()
        .find(|joint| hand.joints()[4].name == joint.name.as_str())
        .expect("a wrist roll");
    compare(&wrist_roll.child.link, pose.base_from_hand());
}

/// Returns the built-in robot with every joint's origin and axis moved, and a fixed spacer in each
/// forearm.
fn reshaped(seeds: Vec<[f64; 9]>) -> Robot {
    let mut urdf = urdf_rs::read_from_string(&TWO_HAND_ARM.urdf).expect("the built-in URDF parses");
    for (joint, seed) in urdf.joints.iter_mut().zip(seeds) {
        for axis in 0..3 {
            joint.origin.xyz[axis] += 0.05 * seed[axis];
            joint.origin.rpy[axis] += 3.0 * seed[3 + axis];
        }
        let skewed =
            Vector3::from(joint.axis.xyz.0) + 0.9 * Vector3::new(seed[6], seed[7], seed[8]);
        joint.axis.xyz.0 = skewed.normalize().into();
    }
    for side in ["left", "right"] {
        let wrist = format!("{side}_wrist_pitch");
        let index = urdf
            .joints
            .iter()
            .position(|joint| joint.name == wrist)
            .expect("a wrist pitch");
        let mut spacer = urdf.joints[index].clone();
        spacer.name = format!("{side}_spacer_fixed");
        spacer.joint_type = JointType::Fixed;
        spacer.child.link = format!("{side}_spacer");
        urdf.joints[index].parent.link = spacer.child.link.clone();
        let mut link = urdf.links[0].clone();
        link.name = spacer.child.link.clone();
        urdf.links.push(link);
        urdf.joints.push(spacer);
    }
    urdf
}

proptest! {
    #[test]
    fn built_in_robot_equals_independent_kinematics(side in side(), fractions in fractions()) {
        let urdf = urdf_rs::read_from_string(&TWO_HAND_ARM.urdf).expect("the built-in URDF parses");
        check_against_urdf(&urdf, &ROBOT, side, &between_limits(ROBOT.hand(side), &fractions));
    }

    #[test]
    fn any_similar_robot_equals_independent_kinematics(
        seeds in prop::collection::vec(prop::array::uniform9(-1.0..1.0_f64), 27),
        side in side(),
        fractions in fractions(),
    ) {
        let urdf = reshaped(seeds);
        let text = urdf_rs::write_to_string(&urdf).expect("the reshaped robot prints");
        let robot = RobotModel::load(&text, &TWO_HAND_ARM.robot_file).expect("the reshaped robot loads");
        check_against_urdf(&urdf, &robot, side, &between_limits(robot.hand(side), &fractions));
    }
}

/// x = −u, y = u × a, z = a, where u is −x of the hand at the straight pose made normal to a.
#[test]
fn tip_frames_follow_the_convention() {
    for side in HandSide::BOTH {
        let pose = ROBOT.hand(side).forward(&HandVector::zeros(JOINTS));
        for finger in 0..2 {
            let frame = &pose.base_from_tip()[finger];
            let a = frame.z_axis();
            let back = -pose.hand_axis();
            let u = (back - a * back.dot(&a)).normalize();
            assert_near("x of the tip", frame.x_axis(), -u, 1e-15);
            assert_near("y of the tip", frame.y_axis(), u.cross(&a), 1e-15);
            // The dome looks 60° inward of the finger, towards the other finger.
            let inward = pose.tip_m(1 - finger) - pose.tip_m(finger);
            let wanted = pose.hand_axis() * FRAC_PI_3.cos() + inward.normalize() * FRAC_PI_3.sin();
            assert_near("dome axis", a, wanted, 1e-12);
        }
    }
}

#[test]
fn fingers_close_inward_with_positive_knuckle_and_distal() {
    let hand = ROBOT.hand(HandSide::Left);
    let distance = |q: &HandVector| {
        let pose = hand.forward(q);
        (pose.tip_m(0) - pose.tip_m(1)).norm()
    };
    let open = *hand.reference();
    for joint in [6, 7, 9, 10] {
        let mut closer = open;
        closer[joint] += 0.1;
        assert!(
            distance(&closer) < distance(&open),
            "joint {joint} opens the hand"
        );
    }
}

#[test]
fn joints_of_the_robot_run_left_then_right_as_in_the_urdf() {
    let urdf = urdf_rs::read_from_string(&TWO_HAND_ARM.urdf).expect("the built-in URDF parses");
    let moving = urdf.joints.iter();
    let moving = moving.filter(|joint| joint.joint_type != JointType::Fixed);
    let wanted: Vec<_> = moving.map(|joint| joint.name.clone()).collect();
    let names: Vec<_> = ROBOT.joints().map(|joint| joint.name.to_string()).collect();
    assert_eq!(names, wanted);
    assert_eq!(ROBOT.joint_count(), wanted.len());
    for side in HandSide::BOTH {
        let (hand, range) = (ROBOT.hand(side), ROBOT.joint_range(side));
        let first = ROBOT.joint(range.start).map(|joint| joint.name);
        assert_eq!(first, Some(hand.joints()[0].name));
        assert_eq!(range.len(), hand.joints().len());
    }
    assert_eq!(ROBOT.joint(22), None);
}
