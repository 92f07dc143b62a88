//! Robots of other structures with the same controller and contact model.

use crate::rig::{Rig, displace, goal, object};
use robot_model::{GraspPose, HandSide, RobotFiles, RobotModel};
use shm_schemas::{Cause, GoalKind, GoalRequest, GoalState};
use sim_backend::{Scene, simulated_skin};

const FLAT: &str = "flat-4x4-4.5";

/// Returns a built-in robot with another skin.
fn with_skin(robot: &str, layout: &str) -> RobotModel {
    let robot = RobotModel::find(robot).expect("built-in robot");
    robot.with_skin(simulated_skin(layout.parse().expect("layout name")))
}

/// Returns a grasp scene with an object misaligned by `yaw_deg`.
fn misaligned_scene(name: &str, yaw_deg: f64, robot: &RobotModel) -> Scene {
    let hand = robot.hand(HandSide::Right);
    let mut scene = Scene::grasp(object(name), HandSide::Right).moved_to_hand(hand);
    displace(&mut scene, 0, [0.0, 0.0, yaw_deg]);
    scene
}

/// Returns the same scene with a lateral offset and a more slippery object.
fn misaligned_slippery_scene(name: &str, y_mm: f64, yaw_deg: f64, robot: &RobotModel) -> Scene {
    let mut scene = misaligned_scene(name, yaw_deg, robot);
    displace(&mut scene, 0, [0.0, y_mm, 0.0]);
    scene.objects[0].object.friction *= 0.85;
    scene
}

/// Grasps and lifts an object below the hand's rest position.
fn grasps(robot: &str, name: &str) {
    let robot = RobotModel::find(robot).expect("built-in robot");
    let scene =
        Scene::grasp(object(name), HandSide::Right).moved_to_hand(robot.hand(HandSide::Right));
    let mut rig = Rig::with_robot(robot, &scene, 1);
    rig.execute_successfully(&goal(GoalKind::GRASP, &scene, HandSide::Right));
    let truth = rig.object();
    assert!(truth.lifted_m > 0.045, "{truth:?}");
    assert_eq!((truth.dropped, truth.crushed), (0, 0), "{truth:?}");
}

#[test]
fn gripper_on_a_stage_grasps() {
    for name in ["wood", "sponge", "paper-box"] {
        grasps("test-bench", name);
    }
}

#[test]
fn redundant_arm_with_gripper_grasps() {
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

/// With one drive both jaws close together: the first to touch pushes the object, and the drive
/// cannot distinguish the sides.
#[test]
fn single_drive_gripper_grasps_an_off_centre_object() {
    for off_m in [-0.003, 0.003] {
        let robot = RobotModel::find("test-bench").expect("built-in robot");
        let hand = robot.hand(HandSide::Right);
        let mut scene = Scene::grasp(object("wood"), HandSide::Right).moved_to_hand(hand);
        scene.objects[0].position_m[1] += off_m;
        let mut rig = Rig::with_robot(robot, &scene, 1);
        rig.execute_successfully(&goal(GoalKind::GRASP, &scene, HandSide::Right));
        assert!(rig.object().lifted_m > 0.045, "{off_m}: {:?}", rig.object());
    }
}

/// Flat and cylindrical fingertips; the robot file describes their elements and compliance.
#[test]
fn flat_and_cylindrical_fingertips_grasp() {
    for robot in ["test-bench", "arm7-gripper"] {
        for layout in [FLAT, "cylinder-4x4-4.5-12"] {
            for name in ["wood", "sponge"] {
                let model = with_skin(robot, layout);
                let scene = Scene::grasp(object(name), HandSide::Right)
                    .moved_to_hand(model.hand(HandSide::Right));
                let mut rig = Rig::with_robot(model, &scene, 1);
                rig.execute_successfully(&goal(GoalKind::GRASP, &scene, HandSide::Right));
                let truth = rig.object();
                assert!(truth.lifted_m > 0.045, "{robot} {layout} {name}: {truth:?}");
                assert_eq!((truth.dropped, truth.crushed), (0, 0), "{truth:?}");
            }
        }
    }
}

/// Regression: a gripper of 80 mm did not release an object of 60 mm, because it could not open by
/// 12 mm per side.
#[test]
fn narrow_gripper_releases_a_wide_object() {
    let files = RobotFiles::find("arm7-gripper").expect("built-in robot");
    let jaw = "left_jaw = { rest_m = 0.035,";
    assert!(files.robot_file.contains(jaw));
    let file = files
        .robot_file
        .replace(jaw, "left_jaw = { rest_m = 0.035, upper = 0.04,")
        .replace("opening_m = [0.02, 0.11]", "opening_m = [0.02, 0.08]");
    let robot = RobotModel::load(&files.urdf, &file).expect("valid robot");
    let widest_m = robot.hand(HandSide::Right).max_opening_m();
    assert!((0.0795..=0.08).contains(&widest_m), "{widest_m}");
    let scene = Scene::pick_place(object("sponge"), HandSide::Right)
        .moved_to_hand(robot.hand(HandSide::Right));
    let mut rig = Rig::with_robot(robot, &scene, 1);
    rig.execute_successfully(&goal(GoalKind::PICK_PLACE, &scene, HandSide::Right));
    assert_eq!(rig.object().dropped, 0, "{:?}", rig.object());
}

/// Regression: flat pads pressed a cap harder with every turn, up to 30 N, while Module 3 requested
/// opening. Domes mistook a slipping cap for a turning one, because the learned force decayed with
/// wrist motion.
#[test]
fn wrist_closes_stiff_caps_in_many_turns() {
    let dome = RobotModel::find("arm7-gripper").expect("built-in robot");
    for (what, robot, friction, thread_n_m) in [
        ("pads", with_skin("arm7-gripper", FLAT), 0.66, 0.010),
        ("domes", dome, 0.45, 0.028),
    ] {
        let mut cap = object("cap");
        cap.friction = friction;
        let thread = cap.thread.as_mut().expect("cap has a thread");
        (thread.friction_n_m, thread.closing_rad) = (thread_n_m, f64::to_radians(395.0));
        let scene = Scene::screw(cap, object("open-bottle"), HandSide::Right);
        let scene = scene.moved_to_hand(robot.hand(HandSide::Right));
        let mut rig = Rig::with_robot(robot, &scene, 1);
        rig.execute_successfully(&goal(GoalKind::SCREW, &scene, HandSide::Right));
        let cap = rig.object();
        let tightness = cap.cap_holding_n_m / cap.cap_friction_n_m;
        assert!((1.3..=2.5).contains(&tightness), "{what}: {tightness}");
        assert_eq!((cap.cap_closed, cap.crushed), (1, 0), "{what}: {cap:?}");
        assert!(cap.max_force_n < 12.0, "{what}: {} N", cap.max_force_n);
    }
}

/// Regression: a misaligned rigid block rotated between two fingertips and one, therefore seemed as
/// soft as a sponge, and was rejected.
#[test]
fn misaligned_rigid_block_is_probed_again() {
    for (name, yaw_deg) in [("slippery-50", 4.5), ("slippery-200", -4.4)] {
        let robot = RobotModel::find("three-finger").expect("built-in robot");
        let scene = misaligned_scene(name, yaw_deg, &robot);
        let mut rig = Rig::with_robot(robot, &scene, 1);
        rig.execute_successfully(&goal(GoalKind::GRASP, &scene, HandSide::Right));
        let truth = rig.object();
        assert!(truth.lifted_m > 0.045, "{name}: {truth:?}");
    }
}

/// Regression: on misaligned faces, the squeeze causes most of the shear. A verified object was
/// classified as sliding, pressed up to F_2 and put back.
#[test]
fn verified_misaligned_object_is_not_put_back() {
    for robot in ["test-bench", "arm7-gripper"] {
        for (name, y_mm, yaw_deg) in [
            ("slippery-200", -1.5, -4.8),
            ("slippery-200", 1.5, 4.2),
            ("slippery-50", 1.5, -4.8),
            ("slippery-50", -1.5, 4.8),
        ] {
            let robot = RobotModel::find(robot).expect("built-in robot");
            let scene = misaligned_slippery_scene(name, y_mm, yaw_deg, &robot);
            let mut rig = Rig::with_robot(robot, &scene, 1);
            rig.execute_successfully(&goal(GoalKind::GRASP, &scene, HandSide::Right));
            let truth = rig.object();
            assert!(truth.lifted_m > 0.045, "{name} {yaw_deg}: {truth:?}");
        }
    }
}

/// Regression: the same squeeze grew with the grip force that answered it, up to F_2 for an object
/// of 50 g.
#[test]
fn squeeze_shear_does_not_raise_grip_to_the_limit() {
    for y_mm in [-1.5, 1.5] {
        let robot = RobotModel::two_hand_arm().expect("built-in robot");
        let scene = misaligned_slippery_scene("slippery-50", y_mm, -4.8, &robot);
        let mut rig = Rig::with_robot(robot, &scene, 1);
        rig.execute_successfully(&goal(GoalKind::GRASP, &scene, HandSide::Right));
        let pressed_n = rig.object().max_force_n;
        assert!(pressed_n < 6.0, "{y_mm} mm: {pressed_n} N");
    }
}

/// Regression: a block too heavy to lift was classified as rotating in the hand, and stayed
/// gripped.
#[test]
fn block_too_heavy_to_lift_is_released() {
    let robot = RobotModel::find("three-finger").expect("built-in robot");
    let mut scene = misaligned_scene("heavy-block", -4.6, &robot);
    scene.objects[0].object.mass_kg = 1.23;
    let mut rig = Rig::with_robot(robot, &scene, 1);
    let end = rig.execute(&goal(GoalKind::GRASP, &scene, HandSide::Right));
    assert_eq!(
        end.state,
        GoalState::REFUSED,
        "{}: {}",
        end.step,
        end.reason
    );
    assert_ne!(end.reason.cause, Cause::NONE);
    let truth = rig.object();
    assert_eq!((truth.stands, truth.pressed), (1, 0), "{truth:?}");
}

/// 5-DOF arm with one fixed and one rotating jaw. Its domes face each other at one opening only,
/// and the hand tilts while closing.
#[test]
fn fixed_and_rotating_jaw_grasp_and_release() {
    let robot = angular_jaw();
    for name in ["wood", "slippery-50", "paper-box", "sponge", "bottle"] {
        let scene =
            Scene::grasp(object(name), HandSide::Right).moved_to_hand(robot.hand(HandSide::Right));
        let mut rig = Rig::with_robot(robot.clone(), &scene.varied(1), 1);
        rig.execute_successfully(&goal(GoalKind::GRASP, &scene, HandSide::Right));
        let truth = rig.object();
        assert!(truth.lifted_m > 0.045, "{name}: {truth:?}");
        assert_eq!((truth.dropped, truth.crushed), (0, 0), "{name}: {truth:?}");
        rig.execute_successfully(&goal(GoalKind::RELEASE, &scene, HandSide::Right));
    }
}

fn angular_jaw() -> RobotModel {
    RobotModel::load(
        include_str!("../../../daemon/robot/tests/robots/angular-jaw.urdf"),
        include_str!("../../../daemon/robot/tests/robots/angular-jaw.toml"),
    )
    .expect("valid robot")
}

/// Regression: the usual place was out of reach. At a rotated place the hand could not open fully,
/// dragged the object along and crushed it.
#[test]
fn five_joint_arm_places_at_its_base_angle() {
    let robot = angular_jaw();
    for name in ["wood", "paper-box", "sponge"] {
        let scene = Scene::pick_place(object(name), HandSide::Right)
            .moved_to_hand(robot.hand(HandSide::Right));
        let place = scene.place.expect("scene has a place");
        assert!(place.yaw_rad < -0.3, "{place:?}");
        let request = goal(GoalKind::PICK_PLACE, &scene, HandSide::Right);
        let mut rig = Rig::with_robot(robot.clone(), &scene.varied(4), 4);
        rig.execute_successfully(&request);
        let truth = rig.object();
        let off_m = (0..2).map(|axis| (truth.position_m[axis] - place.from_m[axis]).abs());
        assert!(off_m.fold(0.0, f64::max) < 0.005, "{name}: {truth:?}");
        assert_eq!((truth.dropped, truth.crushed), (0, 0), "{name}: {truth:?}");
        let misaligned = GoalRequest {
            to_yaw_rad: request.from_yaw_rad,
            ..request
        };
        let refused = rig.rejection_reason(&misaligned);
        assert_eq!(refused.cause(), Cause::UNREACHABLE, "{refused}");
    }
}

/// Regression: jaws with separate drives stood at their stops, because the arm used them to shift
/// the hand laterally.
#[test]
fn independently_driven_jaws_share_the_opening() {
    let files = RobotFiles::find("arm7-gripper").expect("built-in robot");
    let mimic = "<mimic joint=\"left_jaw\"/>";
    assert!(files.urdf.contains(mimic));
    let file = format!(
        "{}right_jaw = {{ rest_m = 0.035, stiffness = 20000, inertia = 0.4 }}\n",
        files.robot_file
    );
    let robot = RobotModel::load(&files.urdf.replace(mimic, ""), &file).expect("valid robot");
    let hand = robot.hand(HandSide::Right);
    for x_m in [0.24, 0.32, 0.42] {
        let centre_m = nalgebra::Vector3::new(x_m, -0.10, 0.05);
        let frame = GraspPose::from_above(centre_m, hand.home_yaw_rad(), 0.07);
        let posture = hand.posture_for(&frame).expect("reachable posture").q;
        let apart_m = (posture[7] - posture[8]).abs();
        assert!(apart_m < 0.001, "at {x_m} m: {posture:?}");
    }
    for name in ["wood", "sponge"] {
        let scene = Scene::pick_place(object(name), HandSide::Right).moved_to_hand(hand);
        let mut rig = Rig::with_robot(robot.clone(), &scene, 1);
        rig.execute_successfully(&goal(GoalKind::PICK_PLACE, &scene, HandSide::Right));
        assert_eq!(rig.object().dropped, 0, "{name}: {:?}", rig.object());
    }
}
