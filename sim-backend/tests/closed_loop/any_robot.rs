//! Robots of other structures before the simulated world: the same controller, the same contacts.

use crate::rig::{Rig, goal, object};
use robot_model::{RobotModel, Side};
use shm_schemas::GoalKind;
use sim_backend::Scene;

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
