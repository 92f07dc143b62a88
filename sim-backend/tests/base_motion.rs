//! Base motion in the world of the robot: standing objects stay in the field, held objects receive
//! inertial forces.

mod common;

use common::Script;
use robot_model::{HandSide, RobotModel};
use shm_schemas::ObjectTruth;
use sim_backend::course::{Base, Floor, Pace, PlanarPose, Wheels};
use sim_backend::engine::{Engine, EngineError, EngineScene, PhysicsState, TickInput};
use sim_backend::{BaseMotion, BaseMotionError, Object, Scene, Sensed, World};

/// Ticks per step of the base.
const STEP_TICKS: usize = 5;

fn wood() -> Object {
    Object::built_in("wood").expect("built-in object")
}

/// Returns the yaw of an upright object, rad.
fn yaw_rad(object: &ObjectTruth) -> f64 {
    let [w, .., z] = object.orientation;
    2.0 * z.atan2(w)
}

#[test]
fn standing_object_stays_while_the_base_drives() {
    let robot = RobotModel::two_hand_arm().expect("the built-in robot loads");
    let stands_m = [1.4, -0.8];
    let mut scene = Scene::grasp(wood(), HandSide::Right);
    (scene.objects[0].position_m, scene.objects[0].yaw_rad) = (stands_m, 0.3);
    let mut world = World::new(&robot, &scene, 1).expect("valid scene");
    let mut base = Base::new(PlanarPose::default(), Floor::bumpy(1, 0));
    let mut sensed = Sensed::default();
    let drives = [(2, 2), (0, 2), (2, 1), (1, 1), (2, 0), (0, 0)];
    for (left, right) in drives {
        for _ in 0..400 {
            base.step(Wheels { left, right }, Pace::Free);
            world
                .set_base_motion(&base.motion())
                .expect("valid base motion");
            for _ in 0..STEP_TICKS {
                world.sense(&mut sensed);
                world.advance(None);
            }
        }
    }
    assert_eq!(world.fault(), None);
    let object = world.truth().objects[0];
    let [x_m, y_m, _] = object.position_m;
    let [field_x_m, field_y_m] = base.pose().point_m([x_m, y_m]);
    let off_m = (field_x_m - stands_m[0]).hypot(field_y_m - stands_m[1]);
    assert!(off_m < 0.005, "moved by {off_m} m");
    let turned_rad = yaw_rad(&object) + base.pose().yaw_rad - 0.3;
    assert!(turned_rad.abs() < 0.02, "rotated by {turned_rad} rad");
    assert!(object.tilt_rad < 1e-3 && object.table_n > 0.0, "{object:?}");
}

/// Lifts wood with this multiple of the required force, then accelerates for 0.25 s. Returns the
/// slip due to the acceleration, m.
fn slip_m(over_grip: f64, ride: BaseMotion) -> f64 {
    let mut script =
        Script::from_nominal_grasp(Scene::grasp(wood(), HandSide::Right), HandSide::Right, 1);
    script.close_to(wood().required_normal_n() * over_grip);
    script.lift(0.02);
    script.ticks(200, |_| ());
    let before_m = script.world.truth().objects[0].slip_in_hand_m;
    script
        .world
        .set_base_motion(&ride)
        .expect("valid base motion");
    script.ticks(250, |_| ());
    script.world.truth().objects[0].slip_in_hand_m - before_m
}

#[test]
fn base_accelerations_load_the_grip() {
    let ride = |acceleration_m_s2: f64, heave_m_s2: f64| BaseMotion {
        acceleration_m_s2,
        heave_m_s2,
        ..BaseMotion::STILL
    };
    let check = |over_grip: f64, ride: BaseMotion, slips: bool| {
        let slip_m = slip_m(over_grip, ride);
        assert_eq!(slip_m > 1e-3, slips, "{over_grip}, {ride:?}: {slip_m} m");
    };
    check(1.3, BaseMotion::STILL, false);
    // 0.5 g upwards adds half of the weight, momentarily all of it, because the step is abrupt;
    // downwards it removes weight.
    check(1.3, ride(0.0, 5.0), true);
    check(2.8, ride(0.0, 5.0), false);
    check(1.3, ride(0.0, -9.81), false);
    // The fingers close along y: forward acceleration acts perpendicular to the weight.
    check(1.3, ride(10.0, 0.0), true);
    check(2.8, ride(10.0, 0.0), false);
}

#[test]
fn impossible_base_motion_is_rejected() {
    let robot = RobotModel::two_hand_arm().expect("the built-in robot loads");
    let scene = Scene::grasp(wood(), HandSide::Right);
    let mut world = World::new(&robot, &scene, 1).expect("valid scene");
    let absurd = BaseMotion {
        turn_rad_s: f64::NAN,
        ..BaseMotion::STILL
    };
    assert!(world.set_base_motion(&absurd).is_err());
    let before = world.truth();
    (0..100).for_each(|_| world.advance(None));
    let after = world.truth();
    assert!((after.objects[0].position_m[0] - before.objects[0].position_m[0]).abs() < 1e-6);
}

/// Engine in which nothing moves.
struct Rest;

impl Engine for Rest {
    fn begin(&mut self, _scene: &EngineScene) -> Result<(), EngineError> {
        Ok(())
    }

    fn advance(&mut self, _input: &TickInput, _out: &mut PhysicsState) -> Result<(), EngineError> {
        Ok(())
    }
}

#[test]
fn external_engine_rejects_a_moving_base() {
    let robot = RobotModel::two_hand_arm().expect("the built-in robot loads");
    let scene = Scene::grasp(wood(), HandSide::Right);
    let world = World::with_engine(&robot, &scene, 1, Box::new(Rest));
    let mut world = world.expect("valid scene");
    let driving = BaseMotion {
        speed_m_s: 0.1,
        ..BaseMotion::STILL
    };
    let rejected = world.set_base_motion(&driving);
    assert_eq!(rejected, Err(BaseMotionError::ExternalEngine));
    assert_eq!(world.set_base_motion(&BaseMotion::STILL), Ok(()));
}

/// The object follows the bumped hand; its inertia loads the grip.
#[test]
fn bump_loads_the_grip() {
    let slip_m = |over_grip: f64, height_m: f64| {
        let scene = Scene::grasp(wood(), HandSide::Right);
        let mut script = Script::from_nominal_grasp(scene, HandSide::Right, 1);
        script.close_to(wood().required_normal_n() * over_grip);
        script.lift(0.02);
        script.ticks(200, |_| ());
        let world = &mut script.world;
        world.restart_slip(0);
        let hand = HandSide::Right.index();
        world.bump(hand, height_m, 0.1).expect("valid bump");
        let begin_m = world.truth().objects[0].position_m[2];
        let mut highest_m = begin_m;
        script.ticks(200, |script| {
            highest_m = highest_m.max(script.world.truth().objects[0].position_m[2]);
        });
        let object = script.world.truth().objects[0];
        (object.slip_in_hand_m, highest_m - begin_m)
    };
    let (still_m, risen_m) = slip_m(2.8, 0.005);
    assert!((risen_m - 0.005).abs() < 1e-3, "rose by {risen_m} m");
    assert!(still_m < 1e-3, "{still_m} m");
    // 10 mm in 0.1 s accelerate with 2 g at most.
    let (slid_m, _) = slip_m(1.3, 0.01);
    assert!(slid_m > 1e-3, "{slid_m} m");
}

#[test]
fn impossible_bump_is_rejected() {
    let robot = RobotModel::two_hand_arm().expect("the built-in robot loads");
    let scene = Scene::grasp(wood(), HandSide::Right);
    let mut world = World::new(&robot, &scene, 1).expect("valid scene");
    for (hand, height_m, duration_s) in [
        (2, 0.005, 0.1),
        (0, f64::NAN, 0.1),
        (0, 0.02, 0.1),
        (0, 0.005, 0.0),
        (0, 0.005, f64::INFINITY),
    ] {
        let bumped = world.bump(hand, height_m, duration_s);
        assert!(bumped.is_err(), "{hand} {height_m} {duration_s}");
    }
}
