//! Scripted squeeze and lift: contact physics decides what is held; equal inputs give equal bits.

mod common;

use common::Script;
use robot_model::HandSide;
use shm_schemas::ObjectTruth;
use sim_backend::{Object, Scene, World};

/// Presses with a multiple of the required force, lifts by 10 mm, waits.
fn squeeze_and_lift(scene: Scene, side: HandSide, over_grip: f64) -> (ObjectTruth, [f64; 2]) {
    let needed_n = scene.objects[0].object.required_normal_n();
    let mut script = Script::from_nominal_grasp(scene, side, 1);
    script.close_to(needed_n * over_grip);
    script.lift(0.01);
    script.ticks(200, |_| ());
    assert_eq!(script.world.fault(), None);
    let truth = script.world.truth();
    let [a, b, ..] = truth.slip_m[side.index()];
    (truth.objects[0], [a, b])
}

#[test]
fn object_is_carried_only_above_the_required_force() {
    // Without the heavy block: a position-holding script loses a fifth of its 24 N during the lift.
    for (index, name) in Object::names()
        .filter(|name| *name != "heavy-block")
        .enumerate()
    {
        let side = HandSide::BOTH[index % 2];
        for (over_grip, carried) in [(0.8, false), (1.3, true)] {
            let object = Object::built_in(name).expect("built-in object");
            let (truth, slip_m) = squeeze_and_lift(Scene::grasp(object, side), side, over_grip);
            let case =
                format!("{name} in the {side:?} hand at {over_grip} times the required force");
            assert_eq!(
                truth.lifted_m > 0.009,
                carried,
                "{case}: lifted by {} m",
                truth.lifted_m
            );
            assert_eq!(
                slip_m[0].max(slip_m[1]) < 0.001,
                carried,
                "{case}: slipped by {slip_m:?} m"
            );
            assert_eq!(truth.dropped, 0, "{case}: dropped");
        }
    }
}

#[test]
fn filled_box_is_crushed_by_its_required_force() {
    for (over_grip, crushed) in [(0.8, 0), (1.3, 1)] {
        let object = Object::built_in("filled-paper-box").expect("built-in object");
        let (truth, _) = squeeze_and_lift(
            Scene::grasp(object, HandSide::Right),
            HandSide::Right,
            over_grip,
        );
        assert_eq!(
            truth.crushed, crushed,
            "pressed with {} N",
            truth.max_force_n
        );
    }
}

#[test]
fn release_in_the_air_is_a_drop() {
    let object = Object::built_in("wood").expect("built-in object");
    let mut script =
        Script::from_nominal_grasp(Scene::grasp(object, HandSide::Right), HandSide::Right, 1);
    script.close_to(5.0);
    script.lift(0.03);
    assert_eq!(script.world.truth().objects[0].dropped, 0);
    script.ticks(500, |script| {
        script
            .frame
            .half_opening_m
            .iter_mut()
            .for_each(|half| *half += 2e-5)
    });
    let truth = script.world.truth().objects[0];
    assert_eq!(truth.dropped, 1);
    assert!(truth.table_n > 0.0, "the object is on the table");
}

#[test]
fn slow_set_down_is_not_a_drop() {
    let object = Object::built_in("wood").expect("built-in object");
    let mut script =
        Script::from_nominal_grasp(Scene::grasp(object, HandSide::Right), HandSide::Right, 1);
    script.close_to(5.0);
    script.lift(0.02);
    script.ticks(2000, |script| script.frame.centre_m.z -= 1e-5);
    script.ticks(500, |script| {
        script
            .frame
            .half_opening_m
            .iter_mut()
            .for_each(|half| *half += 2e-5)
    });
    let truth = script.world.truth().objects[0];
    assert_eq!((truth.dropped, truth.tipped), (0, 0));
    assert!(
        truth.lifted_m.abs() < 1e-4 && truth.tilt_rad < 1e-3,
        "{truth:?}"
    );
}

/// Commands stop in the air: the drives hold their positions and the grip stays.
#[test]
fn grip_stays_without_commands() {
    let object = Object::built_in("wood").expect("built-in object");
    let mut script =
        Script::from_nominal_grasp(Scene::grasp(object, HandSide::Right), HandSide::Right, 1);
    script.close_to(5.0);
    script.lift(0.02);
    let before = script.world.truth();
    (0..1000).for_each(|_| script.world.advance(None));
    let after = script.world.truth();
    assert_eq!(after.expired_commands, 1);
    assert!(
        after.objects[0].lifted_m > 0.019,
        "lifted by {} m",
        after.objects[0].lifted_m
    );
    assert!((after.normal_n[1][0] / before.normal_n[1][0] - 1.0).abs() < 0.05);
}

/// Returns the FNV-1a hash of all sensor data of a grasp.
fn hash_of_a_grasp(seed: u64) -> u64 {
    use zerocopy::IntoBytes;
    let scene = Scene::grasp(
        Object::built_in("bottle").expect("built-in object"),
        HandSide::Left,
    )
    .varied(seed);
    let mut script = Script::from_nominal_grasp(scene, HandSide::Left, seed);
    let mut hash = shm_schemas::layout::FNV_OFFSET;
    script.ticks(2000, |script| {
        script
            .frame
            .half_opening_m
            .iter_mut()
            .for_each(|half| *half -= 2e-6);
        let frames = script.sensed.frames.iter().flatten();
        hash = frames.fold(hash, |hash, frame| {
            shm_schemas::layout::fnv1a(hash, frame.as_bytes())
        });
        hash = shm_schemas::layout::fnv1a(hash, script.sensed.joints.as_bytes());
    });
    hash
}

#[test]
fn same_seed_gives_same_bits_in_threads() {
    let here = hash_of_a_grasp(5);
    let there = std::thread::spawn(|| hash_of_a_grasp(5))
        .join()
        .expect("thread does not panic");
    assert_eq!(here, there);
    assert_ne!(here, hash_of_a_grasp(6));
}

#[test]
fn untouched_world_stays_at_rest() {
    let mut scene = Scene::default();
    for (index, name) in ["bottle", "sponge", "wood", "paper-box"]
        .into_iter()
        .enumerate()
    {
        let object = Object::built_in(name).expect("built-in object");
        scene.objects.push(sim_backend::Placed::new(
            object,
            [0.3, 0.15 * index as f64 - 0.3],
            0.3,
        ));
    }
    let robot = robot_model::RobotModel::two_hand_arm().expect("the built-in robot loads");
    let mut world = World::new(&robot, &scene, 1).expect("valid scene");
    let mut sensed = sim_backend::Sensed::default();
    world.sense(&mut sensed);
    let start = sensed.joints.position;
    (0..2000).for_each(|_| world.advance(None));
    world.sense(&mut sensed);
    assert_eq!(sensed.joints.position, start);
    for truth in &world.truth().objects {
        assert!(
            truth.lifted_m.abs() < 1e-9 && truth.tilt_rad < 1e-7,
            "{truth:?}"
        );
    }
}

/// Grip off the centre of mass: the weight rotates the object about the closing axis, and the
/// ground truth reports the angle.
#[test]
fn off_centre_grip_lets_the_object_rotate() {
    let turned = |aside_m: f64, over_grip: f64| {
        let mut object = Object::built_in("wood").expect("built-in object");
        object.centre_of_mass_m.y = aside_m;
        let (truth, _) = squeeze_and_lift(
            Scene::grasp(object, HandSide::Right),
            HandSide::Right,
            over_grip,
        );
        assert!(truth.lifted_m > 0.005, "{truth:?}");
        truth.turn_in_hand_rad.to_degrees()
    };
    let (even_deg, beside_deg, firm_deg) =
        (turned(0.0, 1.3), turned(0.004, 1.3), turned(0.004, 4.0));
    assert!(even_deg < 2.0, "{even_deg}° with a centred grip");
    assert!(beside_deg > 5.0, "{beside_deg}° with an off-centre grip");
    assert!(
        firm_deg < beside_deg / 2.0,
        "{firm_deg}° with a firm off-centre grip"
    );
}
