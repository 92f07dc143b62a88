//! Robots of other structures before the simulated world: the same controller, the same contacts.

use crate::rig::{Rig, goal, object};
use robot_model::{RobotModel, Side};
use shm_schemas::GoalKind;
use sim_backend::{Scene, simulated_skin};

/// Grasps an object that stands under where the hand rests, and lifts it.
fn grasps(robot: &str, name: &str) {
    let robot = RobotModel::find(robot).expect("it ships");
    let scene = Scene::grasp(object(name), Side::Right).before(robot.hand(Side::Right));
    let mut rig = Rig::of(robot, &scene, 1);
    rig.achieve(&goal(GoalKind::GRASP, &scene, Side::Right));
    let truth = rig.object();
    assert!(truth.lifted_m > 0.045, "{truth:?}");
    assert_eq!((truth.dropped, truth.crushed), (0, 0), "{truth:?}");
}

#[test]
fn a_gripper_on_a_stage_grasps() {
    for name in ["wood", "sponge", "paper-box"] {
        grasps("test-bench", name);
    }
}

#[test]
fn a_redundant_arm_with_a_gripper_grasps() {
    for name in ["wood", "sponge", "paper-box"] {
        grasps("arm7-gripper", name);
    }
}

#[test]
fn two_fingers_grasp_against_one() {
    for name in ["wood", "sponge", "paper-box", "bottle"] {
        grasps("three-finger", name);
    }
}

/// Both jaws of a gripper with one drive close alike: the one that touches first pushes the object before it, and the drive cannot
/// tell on which side it works.
#[test]
fn one_jaw_may_push_an_object_before_the_other_touches() {
    for off_m in [-0.003, 0.003] {
        let robot = RobotModel::find("test-bench").expect("it ships");
        let hand = robot.hand(Side::Right);
        let mut scene = Scene::grasp(object("wood"), Side::Right).before(hand);
        scene.objects[0].position_m[1] += off_m;
        let mut rig = Rig::of(robot, &scene, 1);
        rig.achieve(&goal(GoalKind::GRASP, &scene, Side::Right));
        assert!(rig.object().lifted_m > 0.045, "{off_m}: {:?}", rig.object());
    }
}

/// Fingertips that are no domes, on the same robots: what they feel of a grasp and how they give way is in the robot file.
#[test]
fn pads_and_cylinders_grasp_as_domes_do() {
    for robot in ["test-bench", "arm7-gripper"] {
        for layout in ["flat-4x4-4.5", "cylinder-4x4-4.5-12"] {
            let skin = simulated_skin(layout.parse().expect("a layout"));
            for name in ["wood", "sponge"] {
                let model = RobotModel::find(robot).expect("it ships");
                let scene = Scene::grasp(object(name), Side::Right).before(model.hand(Side::Right));
                let mut rig = Rig::of(model.with_skin(skin), &scene, 1);
                rig.achieve(&goal(GoalKind::GRASP, &scene, Side::Right));
                let truth = rig.object();
                assert!(truth.lifted_m > 0.045, "{robot} {layout} {name}: {truth:?}");
                assert_eq!((truth.dropped, truth.crushed), (0, 0), "{truth:?}");
            }
        }
    }
}
