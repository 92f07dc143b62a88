//! World interface: frames, joint states and invalid commands.

mod common;

use common::Script;
use proptest::prelude::*;
use robot_model::{HandSide, RobotModel};
use shm_schemas::{JointCommand, Layout};
use sim_backend::{LATENCY_MS, Object, START_NS, Scene, Sensed, TICK_NS, World};

/// Joints of the built-in robot.
const JOINTS: usize = 22;

fn world(scene: &Scene) -> World {
    let robot = RobotModel::two_hand_arm().expect("the built-in robot loads");
    World::new(&robot, scene, 1).expect("valid scene")
}

#[test]
fn frames_and_joint_states_match_the_schema() {
    let mut world = world(&Scene::default());
    let mut sensed = Sensed::default();
    for tick in 0..3 {
        world.sense(&mut sensed);
        assert_eq!(world.now_ns(), START_NS + tick * TICK_NS);
        for (hand, frame) in sensed.frames.iter().enumerate() {
            let frame = frame.expect("one frame per tick");
            assert!(frame.is_intact());
            assert_eq!((frame.hand.index(), frame.finger_count), (Some(hand), 2));
            assert_eq!(
                (frame.stamp.sequence, frame.stamp.captured_ns),
                (tick, world.now_ns())
            );
            assert_eq!(frame.layout_hash, Layout::dome_41().hash());
            assert_eq!(frame.valid_mask, [(1 << 41) - 1, (1 << 41) - 1, 0, 0]);
        }
        assert_eq!(sensed.joints.joint_count as usize, JOINTS);
        assert_eq!(
            (
                sensed.joints.stamp.sequence,
                sensed.joints.stamp.captured_ns
            ),
            (tick, world.now_ns())
        );
        world.advance(None);
    }
}

#[test]
fn slow_sensors_sample_without_gaps() {
    for (rate_hz, longest_ticks) in [(1000, 1), (333, 4), (100, 10), (30, 34), (1, 1000)] {
        let mut world = world(&Scene {
            sensor_rate_hz: [rate_hz, 1000],
            ..Scene::default()
        });
        let (mut sensed, mut count, mut last) = (Sensed::default(), 0_u32, 0);
        for tick in 0..1000 {
            world.sense(&mut sensed);
            assert!(sensed.frames[1].is_some(), "the other hand keeps its rate");
            if let Some(frame) = &sensed.frames[0] {
                assert_eq!(frame.stamp.sequence, u64::from(count));
                assert!(
                    tick - last <= longest_ticks,
                    "{rate_hz} Hz: {last} to {tick}"
                );
                (count, last) = (count + 1, tick);
            }
            world.advance(None);
        }
        assert!(count.abs_diff(rate_hz) <= 1, "{rate_hz} Hz: {count} frames");
    }
}

/// In free air the readings are noise of the specified size, in steps of 1 mN.
#[test]
fn noise_in_free_air() {
    for (noise_factor, expected_n) in [(0.0, 0.0), (1.0, 0.003), (2.0, 0.006)] {
        let mut world = world(&Scene {
            noise_factor,
            ..Scene::default()
        });
        let (mut sensed, mut square_n2, mut count) = (Sensed::default(), 0.0, 0.0);
        for _ in 0..100 {
            world.sense(&mut sensed);
            let frames = sensed.frames.iter().flatten();
            for reading in frames
                .flat_map(|f| f.force_n[..2].iter().flat_map(|tip| &tip[..41]))
                .flatten()
            {
                let steps = f64::from(*reading) * 1000.0;
                assert!(
                    (steps - steps.round()).abs() < 1e-4,
                    "{reading} is not a multiple of 1 mN"
                );
                square_n2 += f64::from(*reading) * f64::from(*reading);
                count += 1.0;
            }
            world.advance(None);
        }
        // Rounding adds 1/12 of the squared step to the variance.
        let expected_n2 =
            expected_n * expected_n + if expected_n > 0.0 { 1e-6 / 12.0 } else { 0.0 };
        assert!(
            (square_n2 / count - expected_n2).abs() <= 0.03 * expected_n2,
            "{}",
            (square_n2 / count).sqrt()
        );
    }
}

/// The element readings sum to the true normal force and press each tip outwards.
#[test]
fn readings_agree_with_the_truth() {
    let mut scene = Scene::grasp(
        Object::built_in("wood").expect("built-in object"),
        HandSide::Right,
    );
    scene.noise_factor = 0.0;
    let mut script = Script::from_nominal_grasp(scene, HandSide::Right, 1);
    script.close_to(3.0);
    script.world.sense(&mut script.sensed);
    let (frame, layout) = (
        script.sensed.frames[1].expect("frame in this tick"),
        Layout::dome_41(),
    );
    for finger in 0..2 {
        let along_axis_n: f64 = (0..layout.count)
            .map(|e| {
                let [n, t1, t2] = frame.force_n[finger][e].map(f64::from);
                n * layout.normal[e][2] - t1 * layout.tangent1[e][2] - t2 * layout.tangent2[e][2]
            })
            .sum();
        let truth_n = script.world.truth().normal_n[1][finger];
        // Element gains differ by 3 %; eight elements carry the load.
        assert!(
            (along_axis_n / truth_n - 1.0).abs() < 0.05,
            "fingertip {finger}: {along_axis_n} of {truth_n} N"
        );
    }
    assert!(frame.force_n[0][0][0] > 0.5, "the pole is loaded");
}

/// The vertical forces of all elements sum to the weight of the lifted object.
#[test]
fn the_fingertips_carry_the_weight() {
    let mut scene = Scene::grasp(
        Object::built_in("wood").expect("built-in object"),
        HandSide::Right,
    );
    scene.noise_factor = 0.0;
    let mut script = Script::from_nominal_grasp(scene, HandSide::Right, 1);
    script.close_to(5.0);
    script.lift(0.02);
    script.ticks(200, |_| ());
    let (frame, layout) = (
        script.sensed.frames[1].expect("frame in this tick"),
        Layout::dome_41(),
    );
    let hand = script.robot.hand(HandSide::Right);
    let q = robot_model::HandVector::from_slice(&script.sensed.joints.position[11..22]);
    let pose = hand.forward(&q);
    let mut force_n = nalgebra::Vector3::<f64>::zeros();
    for finger in 0..2 {
        let axes = |e: usize| {
            [layout.normal[e], layout.tangent1[e], layout.tangent2[e]].map(nalgebra::Vector3::from)
        };
        for e in 0..layout.count {
            let ([d, t1, t2], [f_n, f_t1, f_t2]) =
                (axes(e), frame.force_n[finger][e].map(f64::from));
            force_n += pose.base_from_tip()[finger].rotation * (t1 * f_t1 + t2 * f_t2 - d * f_n);
        }
    }
    let weight_n = 0.3 * 9.81;
    assert!(
        (force_n.z + weight_n).abs() < 0.15,
        "{force_n} for a weight of {weight_n} N"
    );
}

/// Lightest allowed object, squeezed much harder than required, rigid and soft.
#[test]
fn lightest_object_survives_a_hard_squeeze() {
    for stiffness in ["", "stiffness_n_m = 2000.0"] {
        let shape = "shape = { kind = \"box\", size_m = [0.06, 0.06, 0.05] }";
        let text =
            format!("name = \"light\"\nmass_kg = 0.0125\nfriction = 0.6\n{stiffness}\n{shape}");
        let object = Object::parse(&text, "light").expect("valid object");
        let mut script =
            Script::from_nominal_grasp(Scene::grasp(object, HandSide::Right), HandSide::Right, 1);
        script.close_to(8.0);
        script.lift(0.01);
        let truth = script.world.truth();
        assert_eq!(script.world.fault(), None);
        let carried = &truth.objects[0];
        assert!(
            (carried.lifted_m - 0.01).abs() < 5e-4 && carried.tilt_rad < 0.02,
            "{carried:?}"
        );
        assert!(
            truth.slip_m[1][0] < 1e-3,
            "slipped by {:?} m",
            truth.slip_m[1]
        );
    }
}

#[test]
fn clock_never_runs_backwards() {
    let mut world = world(&Scene::default());
    world.skip_to(5 * START_NS);
    assert_eq!(world.now_ns(), 5 * START_NS);
    world.skip_to(START_NS);
    world.advance(None);
    assert_eq!(world.now_ns(), 5 * START_NS + TICK_NS);
}

fn command(position: f64, velocity: f64, valid_until_ns: u64) -> JointCommand {
    let mut command = JointCommand {
        joint_count: JOINTS as u32,
        valid_until_ns,
        ..JointCommand::default()
    };
    command.position[..JOINTS].fill(position);
    command.velocity[..JOINTS].fill(velocity);
    command.seal();
    command
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Property: after any finite, sealed command the state is finite and the joints are within
    /// their stops.
    #[test]
    fn state_stays_finite_under_any_command(position in proptest::num::f64::NORMAL, velocity in proptest::num::f64::NORMAL) {
        let robot = RobotModel::two_hand_arm().expect("the built-in robot loads");
        let scene = Scene::grasp(Object::built_in("wood").expect("built-in object"), HandSide::Right);
        let (mut world, mut sensed) = (World::new(&robot, &scene, 1).expect("valid scene"), Sensed::default());
        for _ in 0..20 {
            world.advance(Some(&command(position, velocity, START_NS + 50_000_000)));
        }
        world.sense(&mut sensed);
        prop_assert_eq!(world.fault(), None);
        for (joint, q) in robot.joints().zip(sensed.joints.position) {
            prop_assert!(q >= joint.lower - 1e-4 && q <= joint.upper + 1e-4, "{} {q}", joint.name);
        }
    }

    /// Property: a command that is not finite, damaged or expired changes no bit of the sensor
    /// data.
    #[test]
    fn invalid_commands_change_nothing(
        which in 0..4_usize,
        joint in 0..JOINTS,
        bad in prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(f64::NEG_INFINITY)],
    ) {
        let mut refused = command(0.1, 0.1, START_NS + 50_000_000);
        match which {
            0 => refused.position[joint] = bad,
            1 => refused.velocity[joint] = bad,
            2 => refused.valid_until_ns = START_NS - 1,
            _ => refused.crc32 ^= 1 << joint,
        }
        if which < 3 {
            refused.seal();
        }
        let (mut output, mut silent) = (world(&Scene::default()), world(&Scene::default()));
        let (mut a, mut b) = (Sensed::default(), Sensed::default());
        for _ in 0..LATENCY_MS + 3 {
            output.sense(&mut a);
            silent.sense(&mut b);
            prop_assert_eq!(&a.joints, &b.joints);
            prop_assert_eq!(a.frames, b.frames);
            output.advance(Some(&refused));
            silent.advance(None);
        }
        prop_assert!(output.truth().expired_commands >= 3);
    }
}
