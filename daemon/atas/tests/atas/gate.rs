//! Safety gate: every output is finite, within all limits and sealed, for any input.

use crate::gate_bench::{GateBench, LimitChecker, NO_GRIP, positions, velocities};
use crate::support::JOINTS;
use crate::support::{MS_NS, hand_of, home, robot};
use atas_core::Tick;
use atas_core::kinematics::HandCommand;
use atas_core::limits::JOINT_ACCELERATION_RAD_S2;
use atas_core::safety::{Gate, GateContext, Grip};
use atas_core::settings::Settings;
use proptest::prelude::*;
use robot_model::{HandSide, RobotVector};
use shm_schemas::{Mode, Reason};

fn any_position() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -3.0..3.0,
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -1e300, 5e-324, -0.0]),
    ]
}

fn any_mode() -> impl Strategy<Value = Mode> {
    prop_oneof![6 => Just(Mode::RUN), 1 => prop::sample::select(Mode::ALL)]
}

fn any_grip() -> impl Strategy<Value = Grip> {
    let force = || prop_oneof![3 => 0.0..20.0, 1 => Just(f64::NAN), 1 => Just(f64::INFINITY)];
    ([force(), force()], prop::option::of(0.1..8.0)).prop_map(|(normal_n, f2_n)| Grip {
        normal_n: normal_n.into(),
        f2_n,
    })
}

/// Speed factor per joint, some beyond its capability, held for some ticks.
fn any_leg() -> impl Strategy<Value = (Vec<f64>, usize, Mode)> {
    (
        prop::collection::vec(-2.0..2.0, JOINTS),
        1_usize..120,
        any_mode(),
    )
}

fn any_rate_hz() -> impl Strategy<Value = f64> {
    prop::sample::select(vec![100.0, 1000.0, 2000.0, 4000.0, 10_000.0])
}

proptest! {
    #![proptest_config(crate::support::cases(100))]

    #[test]
    fn arbitrary_commands_stay_within_limits(
        ticks in prop::collection::vec(
            (prop::collection::vec(any_position(), JOINTS), any_mode(), [any_grip(), any_grip()]), 1..60),
    ) {
        let mut rig = GateBench::new();
        let mut judge = LimitChecker::new(&rig);
        rig.closing_m_s = [[0.002; 2]; 2];
        for (wanted, mode, grips) in ticks {
            rig.grips = grips;
            judge.check(&rig.pass(mode, &RobotVector::from_slice(&wanted)))?;
        }
    }

    /// Random walks within the step check: full speed, reversals, position limits, stops.
    #[test]
    fn random_walks_stay_within_limits(
        legs in prop::collection::vec(any_leg(), 1..12), rate_hz in any_rate_hz(),
    ) {
        let mut rig = GateBench::new();
        rig.step_s = 1.0 / rate_hz;
        let mut judge = LimitChecker::new(&rig);
        let speeds: Vec<f64> = robot().joints().map(|j| j.velocity_max).collect();
        for (factors, ticks, mode) in legs {
            for _ in 0..ticks * rig.ticks_per_ms() {
                let at = *rig.gate.position();
                let wanted = RobotVector::from_fn(JOINTS, |i| at[i] + factors[i] * speeds[i] * rig.step_s);
                judge.check(&rig.pass(mode, &wanted))?;
            }
        }
    }

    #[test]
    fn constant_target_is_reached(legs in prop::collection::vec(any_leg(), 1..4)) {
        let mut rig = GateBench::new();
        let speeds: Vec<f64> = robot().joints().map(|j| j.velocity_max).collect();
        for (factors, ticks, _) in legs {
            for _ in 0..ticks {
                let at = *rig.gate.position();
                rig.pass(Mode::RUN, &RobotVector::from_fn(JOINTS, |i| at[i] + factors[i] * speeds[i] * 1e-3));
            }
        }
        for _ in 0..200 {
            rig.pass(Mode::HOLD, &RobotVector::repeat(JOINTS, 0.0));
        }
        let target = rig.gate.position().map(|q| q + 1e-3);
        let target = RobotVector::from_fn(JOINTS, |i| {
            let joint = robot().joint(i).unwrap();
            target[i].clamp(joint.lower, joint.upper)
        });
        let mut last = Vec::new();
        for _ in 0..300 {
            last = positions(&rig.pass(Mode::RUN, &target)).to_vec();
        }
        for (reached, wanted) in last.iter().zip(target.iter()) {
            prop_assert!((reached - wanted).abs() < 1e-6, "reached {reached}, expected {wanted}");
        }
    }

    /// HOLD brakes, then keeps the position bit for bit, for any request and grip force.
    #[test]
    fn hold_brakes_and_keeps_still(
        factors in prop::collection::vec(-1.0..1.0, JOINTS), ticks in 1_usize..150, garbage in any_position(),
        rate_hz in any_rate_hz(),
    ) {
        let mut rig = GateBench::new();
        rig.step_s = 1.0 / rate_hz;
        let speeds: Vec<f64> = robot().joints().map(|j| j.velocity_max).collect();
        let mut moving = RobotVector::repeat(JOINTS, 0.0);
        for _ in 0..ticks * rig.ticks_per_ms() {
            let at = *rig.gate.position();
            let step_s = rig.step_s;
            moving = velocities(&rig.pass(Mode::RUN, &RobotVector::from_fn(JOINTS, |i| at[i] + factors[i] * speeds[i] * step_s)));
        }
        let from = *rig.gate.position();
        rig.grips = [Grip { normal_n: [30.0; 2].into(), f2_n: Some(1.0) }; 2];
        rig.closing_m_s = [[0.002, -0.002]; 2];
        let mut rest = RobotVector::repeat(JOINTS, 0.0);
        for _ in 0..200 * rig.ticks_per_ms() {
            rest = positions(&rig.pass(Mode::HOLD, &RobotVector::repeat(JOINTS, garbage)));
        }
        for i in 0..JOINTS {
            let speed = moving[i].abs();
            let braking_rad = speed * speed / JOINT_ACCELERATION_RAD_S2 + 5e-3 * speed + 1e-3;
            prop_assert!((rest[i] - from[i]).abs() <= braking_rad, "joint {i} moved {} rad", rest[i] - from[i]);
        }
        for _ in 0..50 {
            let safe = rig.pass(Mode::HOLD, &RobotVector::repeat(JOINTS, garbage));
            prop_assert_eq!(positions(&safe), rest);
            prop_assert!(velocities(&safe).iter().all(|v| *v == 0.0));
        }
    }

    #[test]
    fn motion_within_limits_is_tracked_without_lag(
        amplitude in 0.01..0.12_f64, duration_s in 0.4..2.0_f64, joint in 0..JOINTS,
    ) {
        let mut rig = GateBench::new();
        for i in 0..=2000_u32 {
            let tau: f64 = (f64::from(i) * 1e-3 / duration_s).min(1.0);
            let mut wanted = home();
            wanted[joint] += amplitude * tau * tau * tau * (10.0 - 15.0 * tau + 6.0 * tau * tau);
            let safe = rig.pass(Mode::RUN, &wanted);
            prop_assert!((positions(&safe)[joint] - wanted[joint]).abs() < 1e-9);
        }
    }
}

#[test]
fn gate_rejects_non_finite_vectors_as_a_whole() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut rig = GateBench::new();
        let mut wanted = home().map(|q| q + 1e-4);
        wanted[13] = bad;
        let safe = rig.pass(Mode::RUN, &wanted);
        assert_eq!(positions(&safe), home());
        let not_finite = Reason::CommandNotFinite { joint: 13 };
        assert_eq!(rig.gate.refusal(), not_finite);
        rig.pass(Mode::RUN, &home());
        assert!(
            !rig.gate.refusal().is_some(),
            "the refusal ends with its cause"
        );
    }
}

#[test]
fn gate_rejects_jumps_as_a_whole() {
    let mut rig = GateBench::new();
    let mut wanted = home().map(|q| q + 1e-4);
    wanted[4] += 0.5;
    assert_eq!(positions(&rig.pass(Mode::RUN, &wanted)), home());
    let finding = rig.gate.refusal();
    assert!(
        matches!(finding, Reason::CommandStep { joint: 4, step, limit } if step > limit),
        "{finding:?}"
    );
}

#[test]
fn only_run_allows_motion() {
    for mode in Mode::ALL {
        let mut rig = GateBench::new();
        let wanted = home().map(|q| q + 1e-4);
        let moved = positions(&rig.pass(*mode, &wanted)) != home();
        assert_eq!(moved, *mode == Mode::RUN, "{mode}");
    }
}

/// Right hand, side 0: joints 16 to 18 of an arm with joints 11 to 15.
#[test]
fn side_above_grip_ceiling_may_only_open() {
    let ceilings = [
        (15.1, None, true),
        (14.9, None, false),
        (3.1, Some(2.0), true),
        (2.9, Some(2.0), false),
        (f64::NAN, None, true),
    ];
    for (normal_n, f2_n, over) in ceilings {
        for closing_m_s in [0.002, -0.002, 0.0] {
            let mut rig = GateBench::new();
            rig.grips[1] = Grip {
                normal_n: [normal_n, 0.0].into(),
                f2_n,
            };
            rig.closing_m_s[1] = [closing_m_s, 0.002];
            let wanted = home().map(|q| q + 1e-5);
            let moved: Vec<bool> = positions(&rig.pass(Mode::RUN, &wanted))
                .iter()
                .zip(home().iter())
                .map(|(a, b)| a != b)
                .collect();
            let frozen = over && closing_m_s >= 0.0;
            let case = format!("{normal_n} N of {f2_n:?}, closing at {closing_m_s}");
            assert!(moved[16..19].iter().all(|m| *m != frozen), "{case}");
            assert!(moved[11..16].iter().all(|m| *m != over), "arm, {case}");
            assert!(moved[..11].iter().chain(&moved[19..]).all(|m| *m), "{case}");
            let finding = rig.gate.refusal();
            let is_ceiling = matches!(finding, Reason::GripCeiling { side: 0, .. });
            assert_eq!((is_ceiling, finding.is_some()), (over, over), "{case}");
        }
    }
}

/// The jerk limit is in seconds, so the time constant of the catch-up must be as well.
#[test]
fn lag_is_caught_up_without_oscillation() {
    for rate_hz in [100.0, 1000.0, 2000.0, 4000.0, 10_000.0] {
        let mut rig = GateBench::new();
        rig.step_s = 1.0 / rate_hz;
        let (mut wanted, mut overshoot_rad) = (home(), 0.0_f64);
        wanted[6] += 1e-3;
        for _ in 0..(0.2 * rate_hz) as usize {
            let safe = rig.pass(Mode::RUN, &wanted);
            overshoot_rad = overshoot_rad.max(positions(&safe)[6] - wanted[6]);
        }
        let left_rad = (rig.gate.position()[6] - wanted[6]).abs();
        assert!(left_rad < 1e-6, "{rate_hz} Hz: {left_rad} rad remain");
        assert!(
            overshoot_rad < 2e-4,
            "{rate_hz} Hz: overshoot of {overshoot_rad} rad"
        );
    }
}

/// F42, F44.
#[test]
fn following_error_is_reported_after_ten_ticks() {
    let mut rig = GateBench::new();
    let mut measured = home();
    measured[6] -= 0.1;
    rig.measured = Some(measured);
    for _ in 0..9 {
        rig.pass(Mode::RUN, &home());
        assert!(!rig.gate.refusal().is_some());
    }
    rig.measured = Some(home());
    rig.pass(Mode::RUN, &home());
    rig.measured = Some(measured);
    for _ in 0..9 {
        rig.pass(Mode::HOLD, &home());
        assert!(
            !rig.gate.refusal().is_some(),
            "one good tick restarts the count"
        );
    }
    rig.pass(Mode::HOLD, &home());
    let finding = rig.gate.refusal();
    let Reason::FollowingError {
        joint: 6,
        error,
        limit,
    } = finding
    else {
        panic!("{finding:?}")
    };
    assert!((error - 0.1).abs() < 1e-12 && (limit - 0.08).abs() < 1e-12);
}

#[test]
fn fast_joint_has_larger_following_limit() {
    let mut rig = GateBench::new();
    for _ in 0..200 {
        let at = *rig.gate.position();
        let mut wanted = at;
        wanted[1] += 2e-3;
        let mut measured = at;
        measured[1] -= 0.09;
        let fast = rig.pass(Mode::RUN, &wanted).command().velocity[1] > 1.0;
        rig.measured = fast.then_some(measured);
        assert!(!rig.gate.refusal().is_some());
    }
}

#[test]
fn every_command_is_stamped_sealed_and_expires() {
    let mut gate = Gate::new(robot(), 77);
    let settings = Settings::default().safety;
    let raw = HandSide::BOTH.map(|side| HandCommand::new(hand_of(&home(), side), [0.0; 2].into()));
    for index in 0..20 {
        if index == 10 {
            gate.synchronise(&home());
        }
        let mode = Mode::ALL[index as usize % Mode::ALL.len()];
        let tick = Tick {
            index: 3 * index,
            now_ns: 1_000 * MS_NS + 3 * index * MS_NS,
        };
        let ctx = GateContext {
            tick,
            step_s: 1e-3,
            mode,
            measured: None,
            joint_sequence: index + 100,
            grip_limit_n: [0.0, 2.5],
            settings: &settings,
        };
        let command = *gate.pass(&raw, &[NO_GRIP; 2], &ctx).command();
        assert!(command.is_intact());
        assert_eq!(
            (
                command.stamp.sequence,
                command.stamp.captured_ns,
                command.stamp.writer_epoch
            ),
            (index, tick.now_ns, 77)
        );
        assert_eq!(
            (command.tick, command.valid_until_ns),
            (tick.index, tick.now_ns + 5 * MS_NS)
        );
        assert_eq!(
            (command.mode, command.answers_sequence, command.pad),
            (mode, index + 100, 0)
        );
        // Without a known posture the gate commands no joints.
        assert_eq!(command.joint_count, if index < 10 { 0 } else { 22 });
    }
}

#[test]
fn joint_beyond_limit_is_commanded_at_limit() {
    let mut rig = GateBench::new();
    let mut measured = home();
    let upper = robot().joint(2).unwrap().upper;
    measured[2] = upper + 0.04;
    rig.gate.synchronise(&measured);
    let safe = rig.pass(Mode::HOLD, &home());
    assert_eq!((positions(&safe)[2], velocities(&safe)[2]), (upper, 0.0));
}
