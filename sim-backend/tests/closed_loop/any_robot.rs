//! Robots of other structures before the simulated world: the same controller, the same contacts.

use crate::rig::{Rig, goal, object};
use robot_model::{RobotModel, Side};
use shm_schemas::GoalKind;
use sim_backend::{Placed, Scene};

macro_rules! robot {
    ($name:literal) => {
        RobotModel::load(
            include_str!(concat!(
                "../../../daemon/robot/tests/robots/",
                $name,
                "/robot.urdf"
            )),
            include_str!(concat!(
                "../../../daemon/robot/tests/robots/",
                $name,
                "/robot.toml"
            )),
        )
        .expect("a robot")
    };
}

/// Grasps an object that stands under where the hand rests, and lifts it.
fn grasps(robot: RobotModel, name: &str) {
    let hand = robot.hand(Side::Right);
    let home_m = hand.home_m();
    let yaw_rad = hand.yaw_of_joints_rad(hand.reference_rad(), &home_m);
    let scene = Scene {
        objects: vec![Placed::new(object(name), [home_m.x, home_m.y], yaw_rad)],
        ..Scene::default()
    };
    let mut rig = Rig::of(robot, &scene, 1);
    rig.achieve(&goal(GoalKind::GRASP, &scene, Side::Right));
    let truth = rig.object();
    assert!(truth.lifted_m > 0.045, "{truth:?}");
    assert_eq!((truth.dropped, truth.crushed), (0, 0), "{truth:?}");
}

#[test]
fn a_gripper_on_a_stage_grasps() {
    for name in ["wood", "sponge", "paper-box"] {
        grasps(robot!("test-bench"), name);
    }
}

#[test]
fn a_redundant_arm_with_a_gripper_grasps() {
    for name in ["wood", "sponge", "paper-box"] {
        grasps(robot!("arm7-gripper"), name);
    }
}
