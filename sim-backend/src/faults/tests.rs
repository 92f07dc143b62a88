//! Tests of every kind of fault.

use robot_model::RobotModel;

use super::*;
use crate::scene::Scene;
use crate::world::World;

/// Deliveries per tick: right frames and joint states.
struct Arrived {
    frames: Vec<Vec<HandFrame>>,
    joints: Vec<Vec<JointState>>,
}

fn run(faults: &[&str], ticks: u64) -> Arrived {
    let faults: Vec<Fault> = faults
        .iter()
        .map(|text| text.parse().expect("a valid fault"))
        .collect();
    let robot = RobotModel::two_hand_arm().expect("the built-in robot loads");
    let mut world = World::new(&robot, &Scene::default(), 3).expect("a world");
    let (mut injector, mut sensed) = (FaultPipeline::new(&faults, 3), Sensed::default());
    let mut arrived = Arrived {
        frames: Vec::new(),
        joints: Vec::new(),
    };
    for tick in 0..ticks {
        world.sense(&mut sensed);
        let (mut frames, mut joints) = (Vec::new(), Vec::new());
        injector.pass(tick, &sensed, |delivery| match delivery {
            Delivery::Frame(HandSide::Right, frame) => frames.push(*frame),
            Delivery::Frame(HandSide::Left, _) => {}
            Delivery::Joints(state) => joints.push(*state),
        });
        arrived.frames.push(frames);
        arrived.joints.push(joints);
        world.advance(None);
    }
    arrived
}

/// Returns the sequence numbers of the right hand's frames, per tick.
fn counters(fault: &str, ticks: u64) -> Vec<Vec<u64>> {
    let tick = |frames: &Vec<HandFrame>| frames.iter().map(|frame| frame.stamp.sequence).collect();
    run(&[fault], ticks).frames.iter().map(tick).collect()
}

/// Returns the right frame of tick 5 with a fault from tick 3, and without.
fn frame_five(fault: &str) -> (HandFrame, HandFrame) {
    (run(&[fault], 6).frames[5][0], run(&[], 6).frames[5][0])
}

#[test]
fn payloads_pass_unchanged_without_faults() {
    let arrived = run(&[], 4);
    assert!(
        arrived
            .frames
            .iter()
            .all(|frames| frames.len() == 1 && frames[0].is_intact())
    );
    let plain = run(&["drop@1:left"], 4);
    assert_eq!(arrived.frames, plain.frames, "fault of another hand");
    assert_eq!(arrived.joints, plain.joints);
}

#[test]
fn delivery_faults_change_the_sequence() {
    let check = |fault: &str, expected: &[&[u64]]| {
        assert_eq!(counters(fault, expected.len() as u64), expected, "{fault}");
    };
    check("drop@0.002+0.002:right", &[&[0], &[1], &[], &[], &[4]]);
    check("drop=0@0", &[&[0], &[1]]);
    check("delay=2@0.001", &[&[0], &[], &[], &[1], &[2]]);
    check("delay=2@0.001+0.001", &[&[0], &[], &[2], &[1, 3], &[4]]);
    check("duplicate@0.001+0.001", &[&[0], &[1, 1], &[2]]);
    check("reorder@0", &[&[], &[1], &[0], &[3], &[2]]);
    check(
        "burst=3@0.001",
        &[&[0], &[], &[], &[1, 2, 3], &[], &[], &[4, 5, 6]],
    );
    check("epoch@0.002", &[&[0], &[1], &[0], &[1]]);
    check("wrap=2@0", &[&[u64::MAX - 1], &[u64::MAX], &[0], &[1]]);
}

#[test]
fn content_faults_change_the_readings() {
    let (spoilt, clean) = frame_five("freeze@0.003");
    assert_eq!(spoilt.stamp, clean.stamp);
    assert_eq!(spoilt.force_n, run(&[], 6).frames[2][0].force_n);

    let (spoilt, clean) = frame_five("stick=7@0.003");
    let before = run(&[], 6).frames[2][0];
    assert_eq!(spoilt.force_n[0][7], before.force_n[0][7]);
    assert_eq!(spoilt.force_n[0][8], clean.force_n[0][8]);

    let (spoilt, _) = frame_five("nan=3@0.003");
    let nan = |element: &[f32; 3]| element.iter().all(|x| x.is_nan());
    assert_eq!(
        spoilt.force_n[0]
            .iter()
            .filter(|element| nan(element))
            .count(),
        3
    );

    let (spoilt, clean) = frame_five("bias=10@0.003");
    assert!((spoilt.force_n[1][0][0] - clean.force_n[1][0][0] - 0.02).abs() < 1e-6);
    assert_eq!(spoilt.force_n[1][0][1], clean.force_n[1][0][1]);

    assert_eq!(frame_five("saturate@0.003").0.force_n[1][40][0], 25.0);
    assert_eq!(frame_five("huge@0.003").0.force_n[0][0], [1e9; 3]);
    assert!(frame_five("denormal@0.003").0.force_n[0][0][0].is_subnormal());
    assert_eq!(frame_five("foreign@0.003").0.hand, shm_schemas::Hand::LEFT);

    let (spoilt, clean) = frame_five("future=0.5@0.003");
    assert_eq!(
        spoilt.stamp.captured_ns,
        clean.stamp.captured_ns + 500_000_000
    );
    let (spoilt, clean) = frame_five("stale=0.5@0.003");
    assert_eq!(
        spoilt.stamp.captured_ns,
        clean.stamp.captured_ns - 500_000_000
    );
}

/// Only `corrupt` breaks the seal; content faults are resealed.
#[test]
fn only_corrupt_breaks_the_seal() {
    for name in FaultKind::all()
        .iter()
        .map(|info| info.name)
        .filter(|name| *name != "jump")
    {
        let frames = run(&[&format!("{name}@0.003")], 40).frames;
        let intact = frames.iter().flatten().all(HandFrame::is_intact);
        assert_eq!(intact, name != "corrupt", "{name}");
    }
}

#[test]
fn joint_faults_change_joint_feedback() {
    let joints = |fault: &str| run(&[fault], 6).joints;
    assert!(joints("drop@0.003:joints")[5].is_empty());
    assert!(joints("nan=2@0.003:joints")[5][0].position[1].is_nan());
    let (clean, jumped) = (
        joints("drop=0@0:joints")[5][0],
        joints("jump=0.25@0.003")[5][0],
    );
    assert_eq!(jumped.position[21], clean.position[21] + 0.25);
    assert_eq!(
        joints("future=1@0.003:joints")[5][0].stamp.captured_ns,
        clean.stamp.captured_ns + 1_000_000_000
    );
}

#[test]
fn same_seed_drops_the_same_frames() {
    let lost = |fault: &str| {
        counters(fault, 1000)
            .iter()
            .filter(|frames| frames.is_empty())
            .count()
    };
    assert_eq!(lost("drop=0.3@0"), lost("drop=0.3@0"));
    assert!(
        (250..350).contains(&lost("drop=0.3@0")),
        "{}",
        lost("drop=0.3@0")
    );
}

#[test]
fn fault_descriptions_are_parsed_or_rejected() {
    let check = |text: &str, part: &str| match text.parse::<Fault>() {
        Ok(fault) => assert_eq!(part, "", "{text} became {fault:?}"),
        Err(error) => {
            let message = error.to_string();
            assert!(
                !part.is_empty() && message.contains(part),
                "{text}: {message}"
            );
        }
    };
    check("drop@1", "");
    check("drop=0.3@2+0.5:right", "");
    check("jump@0", "");
    check("nan@0:joints", "");
    check("drop", "lacks a start");
    check("", "lacks a start");
    check("fall@1", "unknown kind \"fall\", needs one of drop, delay");
    check("drop=2@1", "value is \"2\", needs 0 to 1");
    check("drop=NaN@1", "value is \"NaN\"");
    check("drop@-1", "start is \"-1\"");
    check("drop@1+x", "length is \"x\"");
    check(
        "drop@1:feet",
        "unsupported target \"feet\", needs one of left, right, hands, joints",
    );
    check("jump@1:left", "needs one of joints");
    check("stick@1:joints", "needs one of left, right, hands");
}
