//! Task scenes under scripted hands: placing, putting on, screwing, and their ground truth.

mod common;

use common::Script;
use nalgebra::Vector3;
use robot_model::{GraspPose, GraspSide, HandSide, RobotModel};
use shm_schemas::ObjectTruth;
use sim_backend::{Mount, Object, Scene, World};
use zerocopy::IntoBytes;

fn part(name: &str) -> Object {
    Object::built_in(name).expect("built-in object")
}

fn screw() -> Scene {
    Scene::screw(part("cap"), part("open-bottle"), HandSide::Right)
}

fn assembly() -> Scene {
    Scene::assembly(part("cap"), part("open-bottle"), HandSide::Right)
}

fn first(script: &Script) -> ObjectTruth {
    script.world.truth().objects[0]
}

/// Moves the hand's centre in a straight line at `speed_m_s`.
fn go(script: &mut Script, to_m: Vector3<f64>, speed_m_s: f64) {
    let way_m = to_m - script.frame.centre_m;
    let ticks = (way_m.norm() / (speed_m_s * 1e-3)).ceil() as usize;
    script.ticks(ticks, |script| {
        script.frame.centre_m += way_m / ticks as f64
    });
}

/// Lowers the hand at 10 mm/s until `there` returns true, at most 40 mm.
fn lower_until(script: &mut Script, there: impl Fn(&Script) -> bool) {
    for _ in 0..4000 {
        if there(script) {
            break;
        }
        script.ticks(1, |script| script.frame.centre_m.z -= 1e-5);
    }
}

/// Opens both fingers by 5 mm at 20 mm/s.
fn open(script: &mut Script) {
    script.ticks(250, |script| {
        let half_m = &mut script.frame.half_opening_m;
        half_m.iter_mut().for_each(|half_m| *half_m += 2e-5);
    });
}

#[test]
fn object_is_placed_on_plates_of_any_height() {
    for step_m in [-0.010, 0.0, 0.010] {
        let mut scene = Scene::pick_place(part("wood"), HandSide::Right);
        scene.plates[1].height_m += step_m;
        let to_m = scene.place.expect("scene has a place").from_m;
        let mut script = Script::from_nominal_grasp(scene, HandSide::Right, 1);
        script.close_to(5.0);
        script.lift(0.030);
        go(
            &mut script,
            Vector3::new(to_m[0], to_m[1], to_m[2] + 0.030),
            0.05,
        );
        lower_until(&mut script, |script| first(script).landed_ns > 0);
        let landed_ns = script.world.now_ns();
        open(&mut script);
        let truth = first(&script);
        assert!(landed_ns - truth.landed_ns <= 1_000_000);
        assert!(truth.released_ns > truth.landed_ns, "{truth:?}");
        assert!(truth.released_above_m < 2e-4, "{truth:?}");
        assert_eq!((truth.dropped, truth.tipped), (0, 0), "{step_m} m");
        let off_m = Vector3::from(truth.position_m).xy() - Vector3::from(to_m).xy();
        assert!(off_m.norm() < 0.001, "{off_m}");
        assert!(
            (truth.lifted_m - step_m).abs() < 3e-4,
            "{} of {step_m} m",
            truth.lifted_m
        );
    }
}

#[test]
fn release_above_the_place_is_a_drop() {
    let mut script = Script::from_nominal_grasp(
        Scene::pick_place(part("wood"), HandSide::Left),
        HandSide::Left,
        1,
    );
    script.close_to(5.0);
    script.lift(0.030);
    open(&mut script);
    assert_eq!(first(&script).dropped, 1, "{:?}", first(&script));
}

/// Simulates one cycle of the square trajectory with a grip of 2 N: turns ±7 mm clockwise, opens,
/// returns.
fn turn_cap(script: &mut Script) {
    let sweep = |script: &mut Script, to_m: f64, ticks: usize| {
        let step_m = (to_m - script.frame.tangential_m[GraspSide::First]) / ticks as f64;
        script.ticks(ticks, |script| {
            script.frame.tangential_m[GraspSide::First] += step_m;
            script.frame.tangential_m[GraspSide::Second] -= step_m;
        });
    };
    sweep(script, 0.007, 400);
    script.close_to(2.0);
    sweep(script, -0.007, 1400);
    open(script);
}

#[test]
fn fingers_screw_the_cap_closed() {
    let mut script = Script::from_nominal_grasp(screw(), HandSide::Right, 1);
    let before = first(&script);
    turn_cap(&mut script);
    let after = first(&script);
    let turned_deg = after.cap_angle_rad.to_degrees();
    assert!(
        (20.0..70.0).contains(&turned_deg),
        "rotation of one cycle: {turned_deg}°"
    );
    let down_m = before.position_m[2] - after.position_m[2];
    let expected_m = 0.003 * after.cap_angle_rad / core::f64::consts::TAU;
    assert!(
        (down_m - expected_m).abs() < 1e-6,
        "{down_m} m of {expected_m} m"
    );
    assert_eq!((after.cap_engaged, after.cap_closed), (1, 0));
    assert!((after.cap_holding_n_m - after.cap_friction_n_m).abs() < 1e-9);
    (0..9).for_each(|_| turn_cap(&mut script));
    let closed = first(&script);
    assert_eq!(closed.cap_closed, 1, "{closed:?}");
    assert!(
        closed.cap_holding_n_m > 1.3 * closed.cap_friction_n_m,
        "{closed:?}"
    );
    assert_eq!((closed.dropped, closed.tipped), (0, 0));
    assert_eq!(script.world.fault(), None);
}

#[test]
fn screwing_repeats_bit_for_bit() {
    let screwed = || {
        let mut script = Script::from_nominal_grasp(screw().varied(3), HandSide::Right, 3);
        turn_cap(&mut script);
        script.world.truth()
    };
    let there = std::thread::spawn(screwed)
        .join()
        .expect("thread does not panic");
    assert_eq!(screwed().as_bytes(), there.as_bytes());
    assert!(there.objects[0].cap_angle_rad > 0.3);
}

#[test]
fn free_bottle_turns_with_its_cap() {
    let mut scene = screw();
    scene.objects[1].mount = Mount::Standing;
    scene.objects[0]
        .object
        .thread
        .as_mut()
        .expect("scene has a cap")
        .friction_n_m = 0.05;
    let mut script = Script::from_nominal_grasp(scene, HandSide::Right, 1);
    turn_cap(&mut script);
    let [cap, bottle, ..] = script.world.truth().objects;
    let yaw_deg = 2.0 * libm::asin(bottle.orientation[3]).to_degrees() - 90.0;
    assert!(yaw_deg < -15.0, "rotated by {yaw_deg}°");
    assert!(cap.cap_angle_rad < 0.3, "{cap:?}");
    assert_eq!((bottle.tipped, bottle.spilt), (0, 0));
}

#[test]
fn a_cap_is_carried_from_its_stand_onto_the_neck() {
    let scene = assembly();
    let to_m = Vector3::from(scene.place.expect("scene has a place").from_m);
    let mut script = Script::from_nominal_grasp(scene, HandSide::Right, 1);
    script.close_to(0.6);
    script.lift(0.12);
    assert!(
        (first(&script).lifted_m - 0.12).abs() < 1e-3,
        "{:?}",
        first(&script)
    );
    go(&mut script, to_m + Vector3::z() * 0.03, 0.05);
    lower_until(&mut script, |script| first(script).cap_engaged == 1);
    open(&mut script);
    script.ticks(100, |_| ());
    let [cap, bottle, ..] = script.world.truth().objects;
    assert_eq!(
        (cap.cap_engaged, cap.dropped, cap.tipped),
        (1, 0, 0),
        "{cap:?}"
    );
    assert!(cap.landed_ns > 0 && cap.released_ns > cap.landed_ns);
    assert_eq!((bottle.tipped, bottle.spilt, bottle.dropped), (0, 0, 0));
    assert!(
        (Vector3::from(cap.position_m) - to_m).norm() < 0.0015,
        "{cap:?}"
    );
    turn_cap(&mut script);
    assert!(first(&script).cap_angle_rad > 0.2, "{:?}", first(&script));
}

/// Returns the left hand's side grasp of the bottle (robot design): 45° below the horizontal, from
/// a bearing of −30°.
fn side_grasp(scene: &Scene) -> GraspPose {
    let hint = scene.grasp_hint(1).expect("scene has a bottle");
    GraspPose {
        hand_azimuth_rad: -30_f64.to_radians(),
        hand_pitch_rad: 45_f64.to_radians(),
        root_rad: -27.5_f64.to_radians(),
        ..GraspPose::from_above(hint.from_m.into(), hint.yaw_rad, hint.width_m + 0.004)
    }
}

#[test]
fn held_bottle_stays_while_its_cap_is_screwed() {
    let mut scene = assembly();
    scene.objects[0].mount = Mount::OnNeck;
    let hint = scene.place.expect("scene has a neck");
    let hold = side_grasp(&scene);
    let right = GraspPose::from_above(hint.from_m.into(), hint.yaw_rad, hint.width_m + 0.004);
    scene.start = Some(Script::from_pose(scene.clone(), HandSide::Right, right, 1).start());
    let mut script = Script::from_pose(scene, HandSide::Left, hold, 1);
    script.close_to(4.0);
    script.change_hand(right);
    (0..8).for_each(|_| turn_cap(&mut script));
    let [cap, bottle, ..] = script.world.truth().objects;
    assert_eq!(cap.cap_closed, 1, "{cap:?}");
    let yaw_deg = 2.0 * libm::asin(bottle.orientation[3]).to_degrees() - 60.0;
    assert!(yaw_deg.abs() < 1.0, "rotated by {yaw_deg}°");
    assert!(bottle.tilt_rad < 0.01, "{bottle:?}");
    assert_eq!((bottle.tipped, bottle.spilt, bottle.crushed), (0, 0, 0));
}

/// Lightest and smallest cap, squeezed much harder than required, then released 10 cm above the
/// table.
#[test]
fn light_cap_survives_hard_squeeze_and_fall() {
    let mut scene = assembly();
    let cap = &mut scene.objects[0].object;
    cap.mass_kg = 0.008;
    cap.friction = 0.8;
    let mut script = Script::from_nominal_grasp(scene, HandSide::Right, 1);
    script.close_to(8.0);
    script.lift(0.05);
    let held = first(&script);
    assert!(
        (held.lifted_m - 0.05).abs() < 1e-3 && held.tilt_rad < 0.03,
        "{held:?}"
    );
    let beside_m = script.frame.centre_m + Vector3::new(0.0, -0.06, 0.0);
    go(&mut script, beside_m, 0.05);
    open(&mut script);
    script.ticks(2000, |_| ());
    let fallen = first(&script);
    assert_eq!((fallen.dropped, script.world.fault()), (1, None));
    assert!(
        fallen.position_m[2] < 0.02,
        "the cap is on the table: {fallen:?}"
    );
    assert!(fallen.released_above_m > 0.08, "{fallen:?}");
}

#[test]
fn cap_placed_off_the_neck_does_not_engage() {
    let scene = assembly();
    let to_m = Vector3::from(scene.place.expect("scene has a place").from_m);
    let mut script = Script::from_nominal_grasp(scene, HandSide::Right, 1);
    script.close_to(0.6);
    script.lift(0.12);
    go(&mut script, to_m + Vector3::new(0.008, 0.0, 0.03), 0.05);
    lower_until(&mut script, |script| first(script).landed_ns > 0);
    open(&mut script);
    script.ticks(1000, |_| ());
    assert_eq!(first(&script).cap_engaged, 0, "{:?}", first(&script));
    assert_eq!(script.world.fault(), None);
}

#[test]
fn untouched_caps_and_bottles_stay_at_rest() {
    let robot = RobotModel::two_hand_arm().expect("the built-in robot loads");
    let mut upright = screw();
    upright.objects[1].mount = Mount::Standing;
    for scene in [screw(), assembly(), upright] {
        let mut world = World::new(&robot, &scene, 1).expect("valid scene");
        let before = world.truth().objects;
        (0..1000).for_each(|_| world.advance(None));
        for (now, before) in world.truth().objects.iter().zip(&before) {
            let moved_m = Vector3::from(now.position_m) - Vector3::from(before.position_m);
            assert!(moved_m.norm() < 1e-4 && now.tilt_rad < 1e-6, "{now:?}");
            assert_eq!((now.dropped, now.tipped, now.spilt), (0, 0, 0));
        }
    }
}

#[test]
fn all_nominal_grasps_are_reachable() {
    let robot = RobotModel::two_hand_arm().expect("the built-in robot loads");
    let reach = |scene: &Scene, side: HandSide, case: &str| {
        let from = scene.grasp_hint(0).expect("scene has an object");
        for hint in [from, scene.place.unwrap_or(from)] {
            let (hand, centre_m) = (robot.hand(side), hint.from_m.into());
            let yaw_rad = hand.closing_yaw_rad(&centre_m, hint.yaw_rad);
            let frame = GraspPose::from_above(centre_m, yaw_rad, hint.width_m + 0.02);
            let reached = hand.posture_for(&frame);
            assert!(reached.is_ok(), "{case}, {side:?}: {hint:?}, {reached:?}");
        }
    };
    for side in HandSide::BOTH {
        for name in Object::names() {
            reach(&Scene::pick_place(part(name), side), side, name);
        }
        for seed in 0..20 {
            let (cap, bottle) = (part("cap"), part("open-bottle"));
            let screw = Scene::screw(cap.clone(), bottle.clone(), side).varied(seed);
            reach(&screw, side, "screw");
            reach(
                &Scene::assembly(cap, bottle, side).varied(seed),
                side,
                "assembly",
            );
        }
    }
}

#[test]
fn cap_and_bottle_families_keep_their_ranges() {
    let nominal = assembly();
    for seed in 0..300 {
        let scene = nominal.varied(seed);
        let [cap, bottle] = &scene.objects[..] else {
            panic!("expected a cap and a bottle");
        };
        let thread = cap.object.thread.expect("cap has a thread");
        let neck = bottle.object.neck.expect("bottle has a neck");
        let inside = [
            (cap.object.shape.width_m() / 2.0, 0.012, 0.020),
            (cap.object.friction, 0.4, 0.8),
            (thread.friction_n_m, 0.005, 0.030),
            (thread.closing_rad.to_degrees(), 120.0, 400.0),
            (thread.pitch_m, 0.002, 0.004),
            (bottle.object.shape.width_m() / 2.0, 0.025, 0.035),
            (neck.rim_m + 0.010, 0.100, 0.160),
            (bottle.object.mass_kg, 0.2, 0.5),
            ((cap.position_m[0] - 0.32).abs(), 0.0, 0.0005),
        ];
        for (value, low, high) in inside {
            assert!((low..=high).contains(&value), "{value} in {low} to {high}");
        }
        let hint = scene.grasp_hint(0).expect("scene has a cap");
        assert_eq!(hint.width_m, cap.object.shape.width_m(), "sizes are known");
        assert_eq!(
            hint.from_m[..2],
            [0.32, -0.18],
            "position errors are unknown"
        );
    }
    let place = Scene::pick_place(part("wood"), HandSide::Right);
    let steps_m: Vec<f64> = (0..300)
        .map(|seed| place.varied(seed).plates[1].height_m)
        .collect();
    assert!(steps_m.iter().all(|step_m| (0.0..=0.020).contains(step_m)));
    assert!(steps_m.iter().any(|step_m| *step_m < 0.001));
    assert!((0..9).all(|seed| place.varied(seed).place == place.place));
}
