//! Robots of other structures: a gripper on a stage, a redundant arm with a gripper, a three-finger
//! hand.

use nalgebra::Vector3;
use proptest::prelude::*;
use robot_model::{
    GraspPose, GraspSide, HandModel, HandPose, HandSide, HandVector, IkStatus, IkWeights, PerSide,
    RobotFiles, RobotModel, SHIPPED,
};

use crate::support::assert_near;

const DT_S: f64 = 1e-3;

/// Robots of other structures than the two-hand arm.
fn robots() -> Vec<RobotFiles> {
    let [_, others @ ..] = SHIPPED;
    others.into()
}

fn load(robot: &RobotFiles) -> RobotModel {
    robot
        .load()
        .unwrap_or_else(|error| panic!("{}: {error}", robot.name))
}

fn any_robot() -> impl Strategy<Value = HandModel> {
    (0..robots().len()).prop_map(|index| *load(&robots()[index]).hand(HandSide::Right))
}

fn between_limits(hand: &HandModel, fractions: &[f64; 16]) -> HandVector {
    HandVector::from_fn(hand.joints().len(), |index| {
        let joint = &hand.joints()[index];
        joint.lower + (joint.upper - joint.lower) * fractions[index]
    })
}

#[test]
fn structures_of_other_robots_are_recognised() {
    // Joints in total, of the arm, and shared; fingertips and the side of each.
    let wanted: [(usize, usize, usize, &[usize]); 3] = [
        (8, 7, 8, &[0, 1]),
        (12, 6, 6, &[0, 0, 1]),
        (2, 1, 2, &[0, 1]),
    ];
    for (robot, (joints, arm, trunk, sides)) in robots().iter().zip(wanted) {
        let model = load(robot);
        assert!(!model.hand(HandSide::Left).is_present(), "{}", robot.name);
        assert_eq!(model.sides().collect::<Vec<_>>(), [HandSide::Right]);
        let hand = model.hand(HandSide::Right);
        assert_eq!(
            (
                model.joint_count(),
                hand.arm_joints().len(),
                hand.trunk_joints().len()
            ),
            (joints, arm, trunk),
            "{}",
            robot.name
        );
        let of: Vec<usize> = (0..hand.fingertip_count())
            .map(|finger| hand.grasp_side(finger).index())
            .collect();
        assert_eq!(of, sides, "{}", robot.name);
    }
}

/// The hand points down and is open in the reference posture.
#[test]
fn the_reference_posture_points_down() {
    for robot in &robots() {
        let model = load(robot);
        let hand = model.hand(HandSide::Right);
        let pose = hand.forward(hand.reference());
        assert_near(&robot.name, pose.hand_axis(), -Vector3::z(), 1e-9);
        for finger in 0..hand.fingertip_count() {
            let inward = pose.side_m(hand.grasp_side(finger).opposite()) - pose.tip_m(finger);
            assert!(pose.dome_axis(finger).dot(&inward) > 0.0, "{}", robot.name);
        }
        assert!(hand.home_opening_m() > 0.03, "{}", hand.home_opening_m());
    }
}

proptest! {
    #![proptest_config(crate::support::cases(200))]

    #[test]
    fn every_column_equals_the_central_difference(hand in any_robot(), fractions in prop::array::uniform16(0.0..=1.0)) {
        const H: f64 = 1e-5;
        let q = between_limits(&hand, &fractions);
        let pose = hand.forward(&q);
        let jacobian = hand.jacobian(&pose);
        for joint in 0..hand.joints().len() {
            let mut step = HandVector::zeros(q.len());
            step[joint] = H;
            let (after, before) = (hand.forward(&(q + step)), hand.forward(&(q - step)));
            let slope = |of: &dyn Fn(&HandPose) -> Vector3<f64>| (of(&after) - of(&before)) / (2.0 * H);
            assert_near("hand axis", jacobian.hand_axis.column(joint).into(), slope(&HandPose::hand_axis), 1e-9);
            for finger in 0..hand.fingertip_count() {
                let tip = jacobian.tips[finger].position.column(joint).into_owned();
                assert_near("tip", tip, slope(&|pose| pose.tip_m(finger)), 1e-9);
                let dome = jacobian.tips[finger].dome_axis.column(joint).into_owned();
                assert_near("dome axis", dome, slope(&|pose| pose.dome_axis(finger)), 1e-9);
            }
        }
    }

    /// Every step is finite and within position and speed limits.
    #[test]
    fn any_grasp_keeps_limits_and_speeds(
        hand in any_robot(),
        fractions in prop::array::uniform16(0.0..=1.0),
        centre in prop::array::uniform3(-2.0..2.0_f64),
        yaw in -7.0..7.0_f64,
        opening_m in prop_oneof![8 => -0.1..0.3_f64, 1 => any::<f64>()],
    ) {
        let target = GraspPose::from_above(centre.into(), yaw, opening_m).target(&hand);
        let mut q = between_limits(&hand, &fractions);
        for _ in 0..5 {
            let pose = hand.forward(&q);
            let step = hand.ik_step(&pose, &hand.jacobian(&pose), &target, DT_S, &IkWeights::TICK);
            prop_assert!(hand.within_limits(&step.q), "{:?}", step.q);
            for (dq, joint) in step.dq.iter().zip(hand.joints()) {
                prop_assert!(dq.abs() <= joint.velocity_max * DT_S + 1e-15, "{} moved {dq}", joint.name);
            }
            prop_assert!(target.is_finite() || step.status == IkStatus::Failed);
            q = step.q;
        }
    }
}

/// A grasp at home, and one 20 mm lower and narrower: reached from scratch, and tracked tick by
/// tick.
#[test]
fn grasp_below_home_is_reached_and_tracked() {
    for robot in &robots() {
        let model = load(robot);
        let hand = model.hand(HandSide::Right);
        let home_m = hand.home_m();
        let yaw = hand.yaw_of_joints_rad(hand.reference(), &home_m);
        let home = GraspPose::from_above(home_m, yaw, hand.home_opening_m());
        let mut q = hand
            .posture_for(&home)
            .unwrap_or_else(|error| panic!("{}: {error}", robot.name))
            .q;
        let below = GraspPose::from_above(home_m - Vector3::z() * 0.02, yaw, 0.03);
        hand.posture_for(&below)
            .unwrap_or_else(|error| panic!("{}: {error}", robot.name));
        let mut worst_m = 0.0_f64;
        for tick in 1..=1000 {
            let share = f64::from(tick) / 1000.0;
            let opening_m = hand.home_opening_m() + (0.03 - hand.home_opening_m()) * share;
            let at = GraspPose::from_above(home_m - Vector3::z() * 0.02 * share, yaw, opening_m);
            let pose = hand.forward(&q);
            let step = hand.ik_step(
                &pose,
                &hand.jacobian(&pose),
                &at.target(hand),
                DT_S,
                &IkWeights::TICK,
            );
            assert_ne!(step.status, IkStatus::Failed, "{}", robot.name);
            q = step.q;
            let pose = hand.forward(&q);
            for (finger, wanted_m) in at.target(hand).tip_m[..hand.fingertip_count()]
                .iter()
                .enumerate()
            {
                worst_m = worst_m.max((pose.tip_m(finger) - wanted_m).norm());
            }
        }
        assert!(worst_m < 1e-6, "{}: {worst_m} m off", robot.name);
    }
}

/// Every grasp of a grid over the workspaces has a posture, at any closing axis if the wrist turns
/// far enough.
#[test]
fn every_grasp_of_a_workspace_has_a_posture() {
    for robot in &robots() {
        let model = load(robot);
        let hand = model.hand(HandSide::Right);
        let space = *hand.workspace().expect("its robot file has one");
        let yaws_deg: &[f64] = match &*robot.name {
            "test-bench" => &[0.0],
            "three-finger" => &[-30.0, 0.0, 30.0],
            _ => &[-90.0, -60.0, -30.0, 0.0, 30.0, 60.0],
        };
        let along = |[from, to]: [f64; 2]| {
            [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(|share| from + (to - from) * share)
        };
        let mut missed = Vec::new();
        for x in along(space.x_m) {
            for y in along(space.y_m) {
                for z in along(space.z_m) {
                    for opening_m in along(space.opening_m) {
                        for yaw_deg in yaws_deg {
                            let centre_m = Vector3::new(x, y, z);
                            let yaw = hand.home_yaw_rad() + yaw_deg.to_radians();
                            let yaw = hand.closing_yaw_rad(&centre_m, yaw);
                            let grasp = GraspPose::from_above(centre_m, yaw, opening_m);
                            if let Err(error) = hand.posture_for(&grasp) {
                                missed.push((centre_m, opening_m, yaw_deg, error.to_string()));
                            }
                        }
                    }
                }
            }
        }
        assert!(
            missed.is_empty(),
            "{}: {} such as {:?}",
            robot.name,
            missed.len(),
            missed[0]
        );
    }
}

/// A gripper turns a cap by its wrist as far as passing fingertips would. A gripper on a stage
/// cannot.
#[test]
fn a_gripper_turns_a_cap_by_its_wrist() {
    let check = |robot: &str, turns_caps: bool, turns_by_wrist: bool| {
        let model = RobotModel::find(robot).expect("it ships");
        let able = model.hand(HandSide::Right).capabilities();
        let wanted = (turns_caps, turns_by_wrist);
        assert_eq!(
            (able.cap_turning, able.cap_turning_by_wrist),
            wanted,
            "{robot}"
        );
    };
    check("two-hand-arm", true, false);
    check("arm7-gripper", true, true);
    // Its two fingers are farther apart than a cap is wide.
    check("three-finger", false, true);
    check("test-bench", false, false);
    let model = RobotModel::find("arm7-gripper").expect("it ships");
    let hand = model.hand(HandSide::Right);
    let mut grasp = GraspPose::from_above(hand.home_m(), hand.home_yaw_rad(), 0.03);
    grasp.tangential_m = PerSide::new(0.006, -0.006);
    let posture = hand.posture_for(&grasp).expect("it turns that far");
    let pose = hand.forward(&posture.q);
    let across = pose.across_m();
    let turned_rad = across.y.atan2(across.x) - hand.home_yaw_rad();
    assert!((turned_rad - 0.006 / 0.012).abs() < 1e-6, "{turned_rad}");
}

/// Regression: the arm compensated for a drive that opened too slowly, so the hand swayed.
#[test]
fn fingers_are_as_fast_as_their_slowest_joint() {
    for robot in SHIPPED {
        let model = load(&robot);
        let speed_m_s = model.hand(HandSide::Right).finger_speed_m_s();
        assert!(
            speed_m_s > 0.09,
            "{}: {speed_m_s} m/s is too slow to let go at once",
            robot.name
        );
    }
    let [_, gripper, ..] = SHIPPED;
    let slower = gripper
        .urdf
        .replace("velocity=\"0.25\"", "velocity=\"0.02\"");
    let slower = RobotFiles {
        urdf: slower.into(),
        ..gripper
    };
    let speed_m_s = load(&slower).hand(HandSide::Right).finger_speed_m_s();
    assert!(
        (speed_m_s - 0.02).abs() < 1e-4,
        "a sliding jaw: {speed_m_s}"
    );
}

/// The two fingers of one side execute requested differences from their middle, without moving the
/// middle: one closes ahead of the other.
#[test]
fn fingers_of_a_side_differ_without_moving_their_middle() {
    let model = RobotModel::find("three-finger").expect("it ships");
    let hand = model.hand(HandSide::Right);
    let grasp = GraspPose::from_above(hand.home_m(), hand.home_yaw_rad(), 0.04);
    let start = hand.posture_for(&grasp).expect("it gets there").q;
    for ahead_m in [0.003, -0.003] {
        let apart_m = grasp.closing_axis() * ahead_m;
        let mut target = grasp.target(hand);
        target.tip_m[0] += apart_m;
        target.tip_m[1] -= apart_m;
        let (middle_m, thumb_m) = ((target.tip_m[0] + target.tip_m[1]) / 2.0, target.tip_m[2]);
        let mut pose = hand.forward(&start);
        for _ in 0..3000 {
            let jacobian = hand.jacobian(&pose);
            let step = hand.ik_step(&pose, &jacobian, &target, DT_S, &IkWeights::TICK);
            assert_ne!(step.status, IkStatus::Failed, "{apart_m:?}");
            pose = hand.forward(&step.q);
        }
        let missed_m = (pose.side_m(GraspSide::First) - middle_m).norm()
            + (pose.side_m(GraspSide::Second) - thumb_m).norm();
        assert!(missed_m < 1e-6, "{apart_m:?}: {missed_m} m off");
        let left_m = (pose.tip_m(0) - target.tip_m[0]).norm() / apart_m.norm();
        assert!(left_m < 0.3, "{apart_m:?}: {left_m} left");
    }
}

/// A gripper whose jaws move together, on a rigid arm, closes symmetrically when only one side is
/// commanded.
#[test]
fn gripper_on_rigid_arm_closes_symmetrically() {
    let model = RobotModel::find("test-bench").expect("it ships");
    let hand = model.hand(HandSide::Right);
    let mut q = *hand.reference();
    let pose = hand.forward(&q);
    let home_m = hand.home_m();
    let yaw = hand.yaw_of_joints_rad(&q, &home_m);
    let half_m = hand.home_opening_m() / 2.0;
    let mut asked = GraspPose::from_above(home_m, yaw, hand.home_opening_m());
    asked.half_opening_m = PerSide::new(half_m - 0.0005, half_m);
    for _ in 0..50 {
        let pose = hand.forward(&q);
        let target = asked.target(hand);
        let step = hand.ik_step(
            &pose,
            &hand.jacobian(&pose),
            &target,
            DT_S,
            &IkWeights::TICK,
        );
        q = step.q;
    }
    let closed = hand.forward(&q);
    let moved_m = (0..2).map(|finger| (closed.tip_m(finger) - pose.tip_m(finger)).norm());
    for moved_m in moved_m {
        assert!((moved_m - 0.00025).abs() < 1e-6, "{moved_m}");
    }
}

/// Regression: every two-hand robot was reported to hold a bottle for the other hand, even if its
/// hands only point down.
#[test]
fn only_arms_that_bend_grasp_from_the_side() {
    for (robot, slants) in [
        ("two-hand-arm", true),
        ("arm7-gripper", true),
        ("three-finger", true),
        ("test-bench", false),
    ] {
        let robot = RobotModel::find(robot).expect("it ships");
        for side in robot.sides() {
            assert_eq!(
                robot.hand(side).capabilities().side_grasp,
                slants,
                "{side:?}"
            );
        }
    }
}
