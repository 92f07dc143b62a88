//! Determinism: equal inputs give equal bits; any inputs give safe outputs.

use crate::support::{MS_NS, frame, joints, robot};
use crate::world::{Logged, World, grasp, start};
use atas_core::{Inputs, Order, Outputs, Tick};
use proptest::prelude::*;
use shm_schemas::{Cause, GoalKind, GoalRequest, Hand, HandFrame, JointState, Reason, Stamp};
use zerocopy::IntoBytes;

#[derive(Clone, Debug)]
struct Heard {
    frames: [Vec<Twist>; 2],
    joints: Option<Twist>,
    order: Option<Order>,
    pause_ms: u64,
}

#[derive(Clone, Copy, Debug)]
enum Twist {
    Sound,
    Value(usize, f64),
    Stamp(u64, u64, u64),
    Unsealed,
    Loud(f32),
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

fn any_twist() -> impl Strategy<Value = Twist> {
    let any_number = || {
        prop_oneof![
            0..5_u64,
            1000 * MS_NS..1200 * MS_NS,
            Just(u64::MAX),
            Just(u64::MAX / 2)
        ]
    };
    prop_oneof![
        12 => Just(Twist::Sound),
        3 => (any::<usize>(), any_value()).prop_map(|(i, v)| Twist::Value(i, v)),
        1 => (any_number(), any_number(), any_number()).prop_map(|(a, b, c)| Twist::Stamp(a, b, c)),
        1 => Just(Twist::Unsealed),
        2 => (-0.5..2.0_f32).prop_map(Twist::Loud),
    ]
}

fn any_order() -> impl Strategy<Value = Order> {
    prop_oneof![
        4 => Just(start(grasp())),
        1 => Just(start(GoalRequest { kind: GoalKind::RELEASE, ..grasp() })),
        1 => (5..9_u64).prop_map(|goal_id| Order::Cancel { goal_id }),
        1 => (5..9_u64).prop_map(|goal_id| Order::ClientGone { goal_id }),
        1 => Just(Order::Stop(Reason::of(Cause::ESTOP))),
        1 => Just(Order::Hold(Reason::limit(Cause::SUPERVISOR_SILENT, 0.8, 0.5))),
        3 => Just(Order::Recover),
        1 => (any::<usize>(), any_value()).prop_map(|(i, value)| Order::SetParameter { index: i % 80, value }),
        1 => (0..4_usize).prop_map(|hand| Order::Bias { hand }),
    ]
}

fn any_tick() -> impl Strategy<Value = Heard> {
    let count = || prop_oneof![8 => Just(1_usize), 1 => Just(0), 1 => Just(3)];
    let frames = || count().prop_flat_map(|n| prop::collection::vec(any_twist(), n));
    let joints = prop_oneof![12 => Just(Some(Twist::Sound)), 1 => any_twist().prop_map(Some), 1 => Just(None)];
    let pause_ms = prop_oneof![30 => Just(0_u64), 1 => 1..50_u64];
    (
        [frames(), frames()],
        joints,
        prop::option::weighted(0.1, any_order()),
        pause_ms,
    )
        .prop_map(|(frames, joints, order, pause_ms)| Heard {
            frames,
            joints,
            order,
            pause_ms,
        })
}

fn twisted_frame(twist: Twist, mut frame: HandFrame) -> HandFrame {
    match twist {
        Twist::Sound => {}
        Twist::Value(i, value) => frame.force_n[i % 2][i / 2 % 64][i / 128 % 3] = value as f32,
        Twist::Stamp(sequence, captured_ns, writer_epoch) => {
            frame.stamp = Stamp {
                sequence,
                captured_ns,
                writer_epoch,
            }
        }
        Twist::Unsealed => frame.pad = 1,
        Twist::Loud(force_n) => frame.force_n = [[[force_n; 3]; 64]; 4],
    }
    if !matches!(twist, Twist::Unsealed) {
        frame.seal();
    }
    frame
}

fn twisted_joints(twist: Twist, mut state: JointState) -> JointState {
    match twist {
        Twist::Sound | Twist::Loud(_) => {}
        Twist::Value(i, value) => state.position_rad[i % 22] = value,
        Twist::Stamp(sequence, captured_ns, writer_epoch) => {
            state.stamp = Stamp {
                sequence,
                captured_ns,
                writer_epoch,
            }
        }
        Twist::Unsealed => state.joint_count = 3,
    }
    if !matches!(twist, Twist::Unsealed) {
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
    for (joint, (q_rad, v_rad_s)) in robot()
        .joints()
        .zip(command.position_rad.iter().zip(&command.velocity_rad_s))
    {
        prop_assert!(
            command.joint_count == 0 || (joint.lower_rad..=joint.upper_rad).contains(q_rad),
            "{}: {q_rad}",
            joint.name
        );
        prop_assert!(
            v_rad_s.abs() <= joint.velocity_max_rad_s * (1.0 + 1e-9),
            "{}: {v_rad_s}",
            joint.name
        );
    }
    for hand in &outputs.report.hands {
        prop_assert!(hand.centre_m.iter().all(|m| m.is_finite()));
        for f in &hand.fingers {
            let felt = [
                f.normal_n,
                f.tangential_n,
                f.tangential_increment_n,
                f.utilisation,
                f.utilisation_now,
                f.friction,
                f.closing_m_s,
            ];
            prop_assert!(felt.iter().all(|v| v.is_finite()), "{f:?}");
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn the_same_inputs_give_the_same_bits_and_garbage_gives_nothing_unsafe(
        ticks in prop::collection::vec(any_tick(), 1..150), start in 0..3_usize,
    ) {
        let mut world = [World::ready, World::reaching, World::holding][start]();
        let mut twin = world.controller.clone();
        for heard in ticks {
            world.ms += 1 + heard.pause_ms;
            let now_ns = world.ms * MS_NS;
            let frames = [Hand::LEFT, Hand::RIGHT].map(|hand| {
                let twists = &heard.frames[hand.index().unwrap()];
                (1..).zip(twists).map(|(i, t)| twisted_frame(*t, frame(hand, world.ms, now_ns - 1000 + i))).collect::<Vec<_>>()
            });
            let state = heard.joints.map(|twist| twisted_joints(twist, joints(world.ms, now_ns, &world.q_rad)));
            let inputs = Inputs {
                tick: Tick { index: world.ms, now_ns },
                frames: [&frames[0], &frames[1]],
                joints: state.as_ref(),
                targets: &[],
                order: heard.order.as_ref(),
            };
            let outputs = *world.controller.step(&inputs);
            prop_assert_eq!(bytes(&outputs), bytes(twin.step(&inputs)));
            check(&outputs)?;
            if outputs.command.joint_count > 0 {
                world.q_rad.copy_from_slice(&outputs.command.position_rad[..22]);
            }
        }
    }
}

/// Replays a recorded grasp in a fresh controller: every byte of every tick is equal, up to the
/// tick with a changed input.
#[test]
fn a_recorded_grasp_replays_byte_for_byte_and_a_changed_one_does_not() {
    let mut world = World::ready();
    let fresh = world.controller.clone();
    (world.has_object, world.log) = (true, Some(Vec::new()));
    let mut recorded = vec![bytes(&world.order(start(grasp())))];
    recorded.extend((0..4000).map(|_| bytes(&world.tick())));
    let log = world.log.take().unwrap();
    let felt = |heard: &Logged| {
        heard.frames[1]
            .iter()
            .any(|f| f.force_n[0] != [[0.0; 3]; 64])
    };
    assert!(log.iter().any(felt), "the object is felt");
    let first_difference = |log: &[Logged]| {
        let mut controller = fresh.clone();
        let mut replayed = log
            .iter()
            .map(|heard| bytes(controller.step(&heard.inputs())));
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
