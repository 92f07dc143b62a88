//! Builders of test inputs.

use nalgebra::Vector3;
use proptest::prelude::ProptestConfig;
use robot_model::{HandSide, HandVector, RobotModel, RobotVector};
use shm_schemas::{Hand, HandFrame, JointState, Layout, Stamp};
use std::sync::LazyLock;

pub(crate) const MS_NS: u64 = 1_000_000;
/// Writer epoch of the sensors.
pub(crate) const EPOCH: u64 = 11;

pub(crate) const JOINTS: usize = 22;

pub(crate) fn robot() -> &'static RobotModel {
    static ROBOT: LazyLock<RobotModel> = LazyLock::new(|| RobotModel::two_hand_arm().unwrap());
    &ROBOT
}

/// Robot with sliding joints only: one stage and one jaw.
pub(crate) fn test_bench() -> &'static RobotModel {
    static ROBOT: LazyLock<RobotModel> = LazyLock::new(|| RobotModel::find("test-bench").unwrap());
    &ROBOT
}

/// Arm with five joints, one fixed and one turning jaw. Its domes tilt as it opens.
pub(crate) fn angular_jaw() -> &'static RobotModel {
    static ROBOT: LazyLock<RobotModel> = LazyLock::new(|| {
        RobotModel::load(
            include_str!("../../../robot/tests/robots/angular-jaw.urdf"),
            include_str!("../../../robot/tests/robots/angular-jaw.toml"),
        )
        .unwrap()
    });
    &ROBOT
}

/// Built-in sensor layout and its hash.
pub(crate) fn dome() -> &'static (Layout, u64) {
    static DOME: LazyLock<(Layout, u64)> = LazyLock::new(|| {
        let dome = Layout::dome_41();
        let hash = dome.hash();
        (dome, hash)
    });
    &DOME
}

/// Cases of a property test; few under Miri, which is a thousand times slower.
pub(crate) fn cases(native: u32) -> ProptestConfig {
    ProptestConfig::with_cases(if cfg!(miri) { 2 } else { native })
}

/// Home position of all joints, rad.
pub(crate) fn home() -> RobotVector {
    home_of(robot())
}

/// Home position of all joints of a robot, rad or m.
pub(crate) fn home_of(robot: &RobotModel) -> RobotVector {
    let mut home = RobotVector::repeat(robot.joint_count(), 0.0);
    for side in HandSide::BOTH {
        home[robot.joint_range(side)].copy_from_slice(robot.hand(side).reference());
    }
    home
}

pub(crate) fn hand_of(q: &RobotVector, side: HandSide) -> HandVector {
    HandVector::from_slice(&q[robot().joint_range(side)])
}

/// Sealed frame without contact; slight noise makes every frame different.
pub(crate) fn frame(hand: Hand, sequence: u64, captured_ns: u64) -> HandFrame {
    let mut frame = HandFrame {
        stamp: Stamp {
            sequence,
            captured_ns,
            writer_epoch: EPOCH,
        },
        layout_hash: dome().1,
        hand,
        finger_count: 2,
        valid_mask: [u64::MAX >> (64 - 41), u64::MAX >> (64 - 41), 0, 0],
        ..HandFrame::default()
    };
    frame.force_n[0][0][1] = (sequence % 7) as f32 * 1e-4;
    frame.force_n[1][3][2] = (sequence % 5) as f32 * 1e-4;
    frame.seal();
    frame
}

/// Adds element forces, object on fingertip in the tactile frame's fingertip coordinates, N, to one
/// fingertip, and seals the frame.
pub(crate) fn press(
    frame: &mut HandFrame,
    finger: usize,
    force_n: impl Fn(Vector3<f64>) -> Vector3<f64>,
) {
    let layout = &dome().0;
    for e in 0..layout.count {
        let d = Vector3::from(layout.normal[e]);
        let (t1, t2) = (
            Vector3::from(layout.tangent1[e]),
            Vector3::from(layout.tangent2[e]),
        );
        let f = force_n(d);
        let reading = [-f.dot(&d), f.dot(&t1), f.dot(&t2)];
        for (sum, now) in frame.force_n[finger][e].iter_mut().zip(reading) {
            *sum += now as f32;
        }
    }
    frame.seal();
}

/// Pressure share of each element for a round contact around `centre`; the sum is one.
pub(crate) fn spread(centre: Vector3<f64>, half_angle_deg: f64) -> impl Fn(Vector3<f64>) -> f64 {
    let weight =
        move |d: Vector3<f64>| (d.dot(&centre) - half_angle_deg.to_radians().cos()).max(0.0);
    let layout = &dome().0;
    let sum: f64 = layout.normal[..layout.count]
        .iter()
        .map(|d| weight(Vector3::from(*d)))
        .sum();
    move |d| weight(d) / sum
}

pub(crate) fn joints(sequence: u64, captured_ns: u64, q: &RobotVector) -> JointState {
    let mut state = JointState {
        stamp: Stamp {
            sequence,
            captured_ns,
            writer_epoch: EPOCH,
        },
        joint_count: JOINTS as u32,
        ..JointState::default()
    };
    state.position[..JOINTS].copy_from_slice(q);
    state.seal();
    state
}
