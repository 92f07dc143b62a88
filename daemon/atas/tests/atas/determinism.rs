//! Determinism: equal inputs give equal bits; any inputs give safe outputs.

use crate::support::{MS_NS, frame, joints, robot};
use crate::world::{Logged, World, grasp, start};
use atas_core::{Inputs, OperatorRequest, Outputs, Tick};
use proptest::prelude::*;
use shm_schemas::{GoalKind, GoalRequest, Hand, HandFrame, JointState, Reason, Stamp};
use zerocopy::IntoBytes;

#[derive(Clone, Debug)]
struct TickData {
    frames: [Vec<Corruption>; 2],
    joints: Option<Corruption>,
    order: Option<OperatorRequest>,
    pause_ms: u64,
}

#[derive(Clone, Copy, Debug)]
enum Corruption {
    Intact,
    Value(usize, f64),
    Stamp(u64, u64, u64),
    Unsealed,
    Force(f32),
}

fn any_value() -> impl Strategy<Value = f64> {
    prop_oneof![
        -3.0..3.0,
        prop::sample::select(vec![
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            1e9,
            -1e300,
            f64::MIN_POSITIVE,
            49.0
        ]),
    ]
}

fn any_corruption() -> impl Strategy<Value = Corruption> {
    let any_number = || {
        prop_oneof![
            0..5_u64,
            1000 * MS_NS..1200 * MS_NS,
            Just(u64::MAX),
            Just(u64::MAX / 2)
        ]
    };
    prop_oneof![
        12 => Just(Corruption::Intact),
        3 => (any::<usize>(), any_value()).prop_map(|(i, v)| Corruption::Value(i, v)),
        1 => (any_number(), any_number(), any_number()).prop_map(|(a, b, c)| Corruption::Stamp(a, b, c)),
        1 => Just(Corruption::Unsealed),
        2 => (-0.5..2.0_f32).prop_map(Corruption::Force),
    ]
}

fn any_request() -> impl Strategy<Value = OperatorRequest> {
    prop_oneof![
        4 => Just(start(grasp())),
        1 => Just(start(GoalRequest { kind: GoalKind::RELEASE, ..grasp() })),
        1 => (5..9_u64).prop_map(|goal_id| OperatorRequest::Cancel { goal_id }),
        1 => (5..9_u64).prop_map(|goal_id| OperatorRequest::ClientDisconnected { goal_id }),
        1 => Just(OperatorRequest::Stop(Reason::Estop)),
        1 => Just(OperatorRequest::Hold(Reason::SupervisorSilent { silent_s: 0.8, limit_s: 0.5 })),
        3 => Just(OperatorRequest::Recover),
        1 => (any::<usize>(), any_value()).prop_map(|(i, value)| OperatorRequest::SetParameter { index: i % 80, value }),
        1 => (0..4_usize).prop_map(|hand| OperatorRequest::Bias { hand }),
    ]
}

fn any_tick() -> impl Strategy<Value = TickData> {
    let count = || prop_oneof![8 => Just(1_usize), 1 => Just(0), 1 => Just(3)];
    let frames = || count().prop_flat_map(|n| prop::collection::vec(any_corruption(), n));
    let joints = prop_oneof![12 => Just(Some(Corruption::Intact)), 1 => any_corruption().prop_map(Some), 1 => Just(None)];
    let pause_ms = prop_oneof![30 => Just(0_u64), 1 => 1..50_u64];
    (
        [frames(), frames()],
        joints,
        prop::option::weighted(0.1, any_request()),
        pause_ms,
    )
        .prop_map(|(frames, joints, order, pause_ms)| TickData {
            frames,
            joints,
            order,
            pause_ms,
        })
}

fn corrupted_frame(twist: Corruption, mut frame: HandFrame) -> HandFrame {
    match twist {
        Corruption::Intact => {}
        Corruption::Value(i, value) => frame.force_n[i % 2][i / 2 % 64][i / 128 % 3] = value as f32,
        Corruption::Stamp(sequence, captured_ns, writer_epoch) => {
            frame.stamp = Stamp {
                sequence,
                captured_ns,
                writer_epoch,
            }
        }
        Corruption::Unsealed => frame.pad = 1,
        Corruption::Force(force_n) => frame.force_n = [[[force_n; 3]; 64]; 4],
    }
    if !matches!(twist, Corruption::Unsealed) {
        frame.seal();
    }
    frame
}

fn corrupted_joints(twist: Corruption, mut state: JointState) -> JointState {
    match twist {
        Corruption::Intact | Corruption::Force(_) => {}
        Corruption::Value(i, value) => state.position[i % 22] = value,
        Corruption::Stamp(sequence, captured_ns, writer_epoch) => {
            state.stamp = Stamp {
                sequence,
                captured_ns,
                writer_epoch,
            }
        }
        Corruption::Unsealed => state.joint_count = 3,
    }
    if !matches!(twist, Corruption::Unsealed) {
        state.seal();
    }
    state
}

fn bytes(outputs: &Outputs) -> Vec<u8> {
    let mut bytes = outputs.command.as_bytes().to_vec();
    bytes.extend(outputs.report.as_bytes());
    bytes.extend(
        outputs
            .goal_update
            .as_ref()
            .map_or(&[][..], IntoBytes::as_bytes),
    );
    bytes.extend(outputs.events.as_slice().as_bytes());
    bytes
}

fn check(outputs: &Outputs) -> Result<(), TestCaseError> {
    let command = &outputs.command;
    prop_assert!(command.is_intact());
    for (joint, (q, v_rad_s)) in robot()
        .joints()
        .zip(command.position.iter().zip(&command.velocity))
    {
        prop_assert!(
            command.joint_count == 0 || (joint.lower..=joint.upper).contains(q),
            "{}: {q}",
            joint.name
        );
        prop_assert!(
            v_rad_s.abs() <= joint.velocity_max * (1.0 + 1e-9),
            "{}: {v_rad_s}",
            joint.name
        );
    }
    for hand in &outputs.report.hands {
        prop_assert!(hand.centre_m.iter().all(|m| m.is_finite()));
        for f in &hand.fingers {
            let measured = [
                f.normal_n,
                f.tangential_n,
                f.tangential_increment_n,
                f.utilisation,
                f.utilisation_now,
                f.friction,
                f.closing_m_s,
            ];
            prop_assert!(measured.iter().all(|v| v.is_finite()), "{f:?}");
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(crate::support::cases(64))]

    #[test]
    fn equal_inputs_give_equal_and_safe_outputs(
        ticks in prop::collection::vec(any_tick(), 1..150), start in 0..3_usize,
    ) {
        let mut world = [World::ready, World::reaching, World::holding][start]();
        let mut twin = world.controller.clone();
        for received in ticks {
            world.ms += 1 + received.pause_ms;
            let now_ns = world.ms * MS_NS;
            let frames = [Hand::LEFT, Hand::RIGHT].map(|hand| {
                let twists = &received.frames[hand.index().unwrap()];
                (1..).zip(twists).map(|(i, t)| corrupted_frame(*t, frame(hand, world.ms, now_ns - 1000 + i))).collect::<Vec<_>>()
            });
            let state = received.joints.map(|twist| corrupted_joints(twist, joints(world.ms, now_ns, &world.q)));
            let inputs = Inputs {
                tick: Tick { index: world.ms, now_ns },
                frames: [&frames[0], &frames[1]],
                joints: state.as_ref(),
                targets: &[],
                request: received.order.as_ref(),
            };
            let outputs = *world.controller.step(&inputs);
            prop_assert_eq!(bytes(&outputs), bytes(twin.step(&inputs)));
            check(&outputs)?;
            if outputs.command.joint_count > 0 {
                world.q.copy_from_slice(&outputs.command.position[..22]);
            }
        }
    }
}

/// Replays a recorded grasp in a fresh controller: every byte of every tick is equal, up to the
/// tick with a changed input.
#[test]
fn recorded_grasp_replays_until_an_input_changes() {
    let mut world = World::ready();
    let fresh = world.controller.clone();
    (world.has_object, world.log) = (true, Some(Vec::new()));
    let mut recorded = vec![bytes(&world.request(start(grasp())))];
    recorded.extend((0..4000).map(|_| bytes(&world.tick())));
    let log = world.log.take().unwrap();
    let measured = |received: &Logged| {
        received.frames[1]
            .iter()
            .any(|f| f.force_n[0] != [[0.0; 3]; 64])
    };
    assert!(log.iter().any(measured), "the object is in contact");
    let first_difference = |log: &[Logged]| {
        let mut controller = fresh.clone();
        let mut replayed = log
            .iter()
            .map(|received| bytes(controller.step(&received.inputs())));
        recorded
            .iter()
            .position(|bytes| Some(bytes) != replayed.next().as_ref())
    };
    assert_eq!(log.len(), recorded.len());
    assert_eq!(first_difference(&log), None);
    let mut changed = log;
    changed[3000].frames[1][0].force_n[0][0][0] += 0.1;
    changed[3000].frames[1][0].seal();
    assert_eq!(first_difference(&changed), Some(3000));
}
