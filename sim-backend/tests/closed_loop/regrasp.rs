//! Objects with a pose error: the hand estimates their pose by touch and regrasps.

use crate::rig::{Rig, displace, goal, object};
use robot_model::{HandSide, RobotModel};
use shm_schemas::GoalKind;
use sim_backend::Scene;

/// Regression: slippery boxes misaligned by 8° were pressed up to F_2 and rejected as too heavy.
/// The face angle used most of the friction.
#[test]
fn misplaced_object_is_regrasped_at_its_estimated_pose() {
    let check = |name: &str, error: [f64; 3], expected: usize| {
        let mut scene = Scene::grasp(object(name), HandSide::Right);
        displace(&mut scene, 0, error);
        let mut rig = Rig::new(&scene);
        rig.execute_successfully(&goal(GoalKind::GRASP, &scene, HandSide::Right));
        let came_again = rig.regrasp_count;
        let truth = rig.object();
        let what = format!("{name} {error:?}: regrasped {came_again} times, {truth:?}");
        assert_eq!(came_again, expected, "{what}");
        assert_eq!((truth.dropped, truth.crushed), (0, 0), "{what}");
        assert!(truth.lifted_m > 0.045, "{what}");
    };
    check("wood", [0.0, 0.0, 0.0], 0);
    check("wood", [1.0, -1.5, 4.0], 0);
    check("wood", [2.0, 2.0, -13.0], 1);
    check("slippery-50", [0.0, 0.0, -9.0], 1);
    check("slippery-200", [0.0, 1.0, 12.0], 1);
    // So light that the first fingertip to touch pushes it to the middle.
    check("sponge", [0.0, 4.0, 3.0], 0);
    check("bottle", [-4.5, 1.0, 0.0], 1);
}

/// The remaining offset in the hand is corrected when the object is placed.
#[test]
fn placing_corrects_the_offset_in_the_hand() {
    for (name, error) in [
        ("wood", [0.0, 2.5, 0.0]),
        ("wood", [0.0, -4.5, 0.0]),
        ("bottle", [2.0, 1.5, 0.0]),
        ("bottle", [-4.0, -3.0, 0.0]),
    ] {
        let mut scene = Scene::pick_place(object(name), HandSide::Right);
        displace(&mut scene, 0, error);
        let mut rig = Rig::new(&scene);
        rig.execute_successfully(&goal(GoalKind::PICK_PLACE, &scene, HandSide::Right));
        let at_m = rig.object().position_m;
        let to_m = scene.place.expect("scene has a place").from_m;
        let off_m = f64::hypot(at_m[0] - to_m[0], at_m[1] - to_m[1]);
        assert!(
            off_m < 1e-3,
            "{name} {error:?}: {off_m} m off its place, {at_m:?} for {to_m:?}"
        );
    }
}

/// Regression: a cap never met its thread if its place or its bottle's was wrong by 3 mm.
#[test]
fn displaced_cap_and_bottle_are_assembled() {
    for (cap, bottle) in [
        ([3.0, -3.0, 2.0], [0.0, 0.0, 0.0]),
        ([0.0, 0.0, 0.0], [-3.0, 2.0, 0.0]),
        ([-3.0, 2.5, 10.0], [3.0, 1.5, 0.0]),
    ] {
        let mut scene = Scene::assembly(object("cap"), object("open-bottle"), HandSide::Right);
        displace(&mut scene, 0, cap);
        displace(&mut scene, 1, bottle);
        let mut rig = Rig::new(&scene);
        rig.execute_successfully(&goal(GoalKind::ASSEMBLE, &scene, HandSide::Right));
        let truth = rig.world.truth().objects;
        let what = format!("cap {cap:?}, bottle {bottle:?}: {truth:?}");
        assert_eq!(
            (truth[0].cap_engaged, truth[0].cap_closed),
            (1, 1),
            "{what}"
        );
        assert_eq!(
            (truth[1].crushed, truth[1].tipped, truth[1].dropped),
            (0, 0, 0),
            "{what}"
        );
    }
}

/// A hand on a lift without lateral motion grasps the object where it is.
#[test]
fn hand_without_lateral_motion_does_not_regrasp() {
    let robot = RobotModel::find("test-bench").expect("built-in robot");
    let mut scene =
        Scene::grasp(object("wood"), HandSide::Right).moved_to_hand(robot.hand(HandSide::Right));
    displace(&mut scene, 0, [0.0, 0.0, 8.0]);
    let mut rig = Rig::with_robot(robot, &scene, 1);
    rig.execute_successfully(&goal(GoalKind::GRASP, &scene, HandSide::Right));
    assert_eq!(rig.regrasp_count, 0);
}

/// Hands with other fingers regrasp too.
#[test]
fn other_robots_regrasp_misplaced_objects() {
    for (name, object_name, error) in [
        ("arm7-gripper", "wood", [0.0, 0.0, 12.0]),
        ("three-finger", "wood", [0.0, 4.0, 0.0]),
    ] {
        let robot = RobotModel::find(name).expect("built-in robot");
        let hand = robot.hand(HandSide::Right);
        let mut scene = Scene::grasp(object(object_name), HandSide::Right).moved_to_hand(hand);
        displace(&mut scene, 0, error);
        let mut rig = Rig::with_robot(robot, &scene, 1);
        rig.execute_successfully(&goal(GoalKind::GRASP, &scene, HandSide::Right));
        let came_again = rig.regrasp_count;
        let truth = rig.object();
        let what = format!("{name} {object_name} {error:?}: {came_again}, {truth:?}");
        assert_eq!(came_again, 1, "{what}");
        assert!(truth.lifted_m > 0.045 && truth.dropped == 0, "{what}");
    }
}

/// Regression: a block with its centre of mass 4 mm off the grip was rejected as too heavy, or
/// rotated in the hand.
#[test]
fn tilting_object_is_regrasped_near_its_centre_of_mass() {
    for (name, beside_mm, yaw_deg) in [
        ("slippery-200", 4.0, 0.0),
        ("slippery-200", -4.0, 0.0),
        ("slippery-50", 6.0, -10.0),
        ("paper-box", -6.0, 12.0),
    ] {
        let mut scene = Scene::pick_place(object(name), HandSide::Right);
        displace(&mut scene, 0, [0.0, 0.0, yaw_deg]);
        scene.objects[0].object.centre_of_mass_m.y += beside_mm * 1e-3;
        let mut rig = Rig::new(&scene);
        rig.execute_successfully(&goal(GoalKind::PICK_PLACE, &scene, HandSide::Right));
        let truth = rig.object();
        let to_m = scene.place.expect("scene has a place").from_m;
        let off_m = f64::hypot(truth.position_m[0] - to_m[0], truth.position_m[1] - to_m[1]);
        let what = format!("{name} {beside_mm} mm, {yaw_deg}°: {off_m} m off its place, {truth:?}");
        assert_eq!((truth.dropped, truth.crushed), (0, 0), "{what}");
        assert!(off_m < 1e-3 && truth.turn_in_hand_rad < 0.1, "{what}");
    }
}
