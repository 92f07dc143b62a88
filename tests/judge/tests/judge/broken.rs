//! Broken controllers: each one is a small change of the correct stream, and is rejected.

use atas_judge::{Promise, ViolationKind};
use shm_schemas::{JointCommand, Mode, ObjectTruth};

use crate::reference::{
    AGAIN, CRUISE, Event, FAULT, HOLD, LIFTED, RECOVERED, RESTART, RESUME, RUN, STEP_S, STOP,
    TICK_NS, Tick, VALID_NS, correct, observed,
};

/// Name, change and expected first violation.
type Case = (&'static str, fn(&mut Vec<Tick>), ViolationKind);

/// Joints of the reference robot.
const SHOULDER: usize = 0;
const JAW: usize = 2;

const NUMBERS: &[Case] = &[
    (
        "NaN in one position",
        |ticks| ticks[CRUISE].command.position[SHOULDER] = f64::NAN,
        ViolationKind::NotFinite,
    ),
    (
        "infinite feed-forward",
        |ticks| ticks[CRUISE].command.velocity[JAW] = f64::INFINITY,
        ViolationKind::NotFinite,
    ),
    (
        "NaN as force limit",
        |ticks| ticks[CRUISE].command.grip_limit_n[1] = f64::NAN,
        ViolationKind::NotFinite,
    ),
    (
        "one joint too many",
        |ticks| ticks[CRUISE].command.joint_count = 4,
        ViolationKind::JointCount,
    ),
    (
        "no joints in RUN",
        |ticks| ticks[CRUISE].command.joint_count = 0,
        ViolationKind::JointCount,
    ),
    (
        "no joints in HOLD, although they are known",
        |ticks| ticks[HOLD + 50].command.joint_count = 0,
        ViolationKind::JointCount,
    ),
];

const MOTIONS: &[Case] = &[
    (
        "1 µrad beyond the limit",
        |ticks| beyond_limit(ticks),
        ViolationKind::Position,
    ),
    (
        "1 % too fast",
        |ticks| too_fast(ticks, 1.01),
        ViolationKind::Speed,
    ),
    (
        "1 ppm too fast",
        |ticks| too_fast(ticks, 1.000_001),
        ViolationKind::Speed,
    ),
    (
        "acceleration 2 % too high",
        |ticks| push(ticks, SHOULDER, CRUISE, &STRONG, 1.0),
        ViolationKind::Acceleration,
    ),
    (
        "jerk 2 % too high",
        |ticks| push(ticks, SHOULDER, CRUISE, &[30.6, 0.0, -30.6], 1.0),
        ViolationKind::Jerk,
    ),
    (
        "jerk of a prismatic joint 2 % too high",
        |ticks| push(ticks, JAW, CRUISE, &[3.06, 0.0, -3.06], 1.0),
        ViolationKind::Jerk,
    ),
    (
        "jump at entering HOLD",
        |ticks| shift(ticks, SHOULDER, HOLD, 1e-3),
        ViolationKind::Speed,
    ),
    (
        "small jump at leaving HOLD",
        |ticks| shift(ticks, SHOULDER, RESUME, 1e-4),
        ViolationKind::Acceleration,
    ),
    (
        "jump at entering SAFE_STOP",
        |ticks| shift(ticks, JAW, STOP, 1e-5),
        ViolationKind::Acceleration,
    ),
    (
        "jump at the recovery",
        |ticks| shift(ticks, JAW, RECOVERED, 1e-5),
        ViolationKind::Acceleration,
    ),
    (
        "jump after the restart",
        |ticks| shift(ticks, SHOULDER, RESTART, 1e-5),
        ViolationKind::Restart,
    ),
    (
        "moves at the restart",
        |ticks| ticks[AGAIN].command.velocity[SHOULDER] = 0.1,
        ViolationKind::Restart,
    ),
    (
        "does not brake in HOLD",
        does_not_brake,
        ViolationKind::Motion,
    ),
    (
        "accelerates in HOLD",
        |ticks| push(ticks, SHOULDER, HOLD, &GENTLE, 5.0),
        ViolationKind::Motion,
    ),
    (
        "opens the hand in HOLD",
        |ticks| push(ticks, JAW, HOLD + 60, &GENTLE, 1e-2),
        ViolationKind::Motion,
    ),
    (
        "drifts by 0.1 pm per tick in HOLD",
        drifts,
        ViolationKind::Motion,
    ),
    (
        "moves in SAFE_STOP",
        |ticks| push(ticks, SHOULDER, STOP + 20, &GENTLE, 1.0),
        ViolationKind::Motion,
    ),
    (
        "moves at entering FAULT",
        |ticks| push(ticks, JAW, FAULT, &[0.1], 1.0),
        ViolationKind::Motion,
    ),
    (
        "feed-forward 1 % too high",
        |ticks| ticks[CRUISE].command.velocity[SHOULDER] *= 1.01,
        ViolationKind::FeedForward,
    ),
    (
        "feed-forward at rest",
        |ticks| ticks[HOLD + 80].command.velocity[SHOULDER] = 1e-12,
        ViolationKind::FeedForward,
    ),
];

const STAMPS: &[Case] = &[
    (
        "sequence number repeats",
        |ticks| {
            renumber(&mut ticks[CRUISE..RESTART], |command| {
                command.stamp.sequence -= 1
            })
        },
        ViolationKind::Sequence,
    ),
    (
        "sequence gap",
        |ticks| {
            renumber(&mut ticks[CRUISE..RESTART], |command| {
                command.stamp.sequence += 1
            })
        },
        ViolationKind::Sequence,
    ),
    (
        "sequence continues after the restart",
        |ticks| {
            renumber(&mut ticks[RESTART..], |command| {
                command.stamp.sequence += 620
            })
        },
        ViolationKind::Sequence,
    ),
    (
        "epoch changes without a restart",
        |ticks| {
            renumber(&mut ticks[CRUISE..RESTART], |command| {
                command.stamp.writer_epoch = 8
            })
        },
        ViolationKind::WriterEpoch,
    ),
    (
        "process replaced without notice",
        |ticks| ticks[RESTART].events.clear(),
        ViolationKind::WriterEpoch,
    ),
    (
        "captured time goes back",
        |ticks| delay(&mut ticks[CRUISE..=CRUISE], -2),
        ViolationKind::CapturedTime,
    ),
    (
        "captured time stands still",
        |ticks| delay(&mut ticks[CRUISE..], -1),
        ViolationKind::CapturedTime,
    ),
    (
        "period 1 % too long",
        |ticks| ticks[CRUISE].command.stamp.captured_ns += TICK_NS / 100,
        ViolationKind::CapturedTime,
    ),
    (
        "missed tick",
        |ticks| {
            delay(&mut ticks[CRUISE..], 1);
            renumber(&mut ticks[CRUISE..RESTART], |command| command.tick += 1);
        },
        ViolationKind::MissedTick,
    ),
    (
        "lost command",
        |ticks| drop(ticks.remove(CRUISE)),
        ViolationKind::Sequence,
    ),
    (
        "tick counter jumps",
        |ticks| renumber(&mut ticks[CRUISE..RESTART], |command| command.tick += 5),
        ViolationKind::TickCounter,
    ),
    (
        "tick counter stands still",
        |ticks| renumber(&mut ticks[CRUISE..RESTART], |command| command.tick -= 1),
        ViolationKind::TickCounter,
    ),
    (
        "validity 1 ns too long",
        |ticks| ticks[CRUISE].command.valid_until_ns += 1,
        ViolationKind::Validity,
    ),
    (
        "validity over at once",
        |ticks| ticks[CRUISE].command.valid_until_ns -= VALID_NS,
        ViolationKind::Validity,
    ),
];

const MODES: &[Case] = &[
    (
        "leaves SAFE_STOP without a recovery",
        |ticks| ticks[RECOVERED].events.clear(),
        ViolationKind::Transition,
    ),
    (
        "leaves FAULT",
        |ticks| set_mode(&mut ticks[FAULT + 20..], Mode::READY),
        ViolationKind::Transition,
    ),
    (
        "recovers to READY at once",
        |ticks| set_mode(&mut ticks[RECOVERED..RECOVERED + 40], Mode::READY),
        ViolationKind::Transition,
    ),
    (
        "unknown mode",
        |ticks| set_mode(&mut ticks[CRUISE..=CRUISE], Mode(9)),
        ViolationKind::Transition,
    ),
    (
        "restarts in READY",
        |ticks| set_mode(&mut ticks[RESTART..AGAIN], Mode::READY),
        ViolationKind::Transition,
    ),
    (
        "HOLD one tick too late",
        |ticks| {
            ticks[HOLD].events.clear();
            ticks[HOLD - 3].events = vec![reach(2)];
        },
        ViolationKind::PromiseBroken,
    ),
    (
        "commands end before the promised HOLD",
        |ticks| {
            ticks.truncate(HOLD - 1);
            ticks[HOLD - 3].events = vec![reach(5)];
        },
        ViolationKind::PromiseBroken,
    ),
    (
        "HOLD at a tolerated fault",
        |ticks| ticks[HOLD - 10].events = vec![Event::Promise(Promise::avoid(&[Mode::HOLD], 10))],
        ViolationKind::ForbiddenMode,
    ),
];

const WORLDS: &[Case] = &[
    (
        "object crushed",
        |ticks| change(&mut ticks[CRUISE..], |object| object.crushed = 1),
        ViolationKind::ObjectCrushed,
    ),
    (
        "object dropped",
        |ticks| change(&mut ticks[CRUISE..], |object| object.dropped = 1),
        ViolationKind::ObjectDropped,
    ),
    (
        "object tipped over",
        |ticks| change(&mut ticks[CRUISE..], |object| object.tipped = 1),
        ViolationKind::ObjectTipped,
    ),
    (
        "bottle spilt",
        |ticks| change(&mut ticks[CRUISE..], |object| object.spilt = 1),
        ViolationKind::ObjectSpilt,
    ),
    (
        "opens the hand with the object",
        |ticks| opens_hand(ticks),
        ViolationKind::GripLost,
    ),
    (
        "object slides in the hand",
        |ticks| {
            change(&mut ticks[LIFTED + 9..], |object| {
                object.slip_in_hand_m = 0.0041
            })
        },
        ViolationKind::GripSlip,
    ),
    (
        "unknown slip in the hand",
        |ticks| {
            change(&mut ticks[LIFTED + 9..], |object| {
                object.slip_in_hand_m = f64::NAN
            })
        },
        ViolationKind::GripSlip,
    ),
    (
        "object turns in the hand",
        |ticks| {
            change(&mut ticks[LIFTED + 9..], |object| {
                object.turn_in_hand_rad = 0.18
            })
        },
        ViolationKind::GripTurn,
    ),
    (
        "object vanishes from the hand",
        |ticks| {
            let lifted = &mut ticks[LIFTED + 9..];
            lifted
                .iter_mut()
                .for_each(|tick| tick.truth.object_count = 0);
        },
        ViolationKind::GripLost,
    ),
];

/// Accelerations of which one exceeds the limit of 60; their sum is 0.
const STRONG: [f64; 12] = [
    30.0, 60.0, 61.2, 60.0, 30.0, 0.0, -30.0, -60.0, -60.0, -60.0, -30.0, -1.2,
];
/// Gentle motion; the sum of the accelerations is 0.
const GENTLE: [f64; 6] = [1.0, 2.0, 1.0, -1.0, -2.0, -1.0];

/// Adds accelerations, times a factor, to a joint; a constant displacement remains.
fn push(ticks: &mut [Tick], joint: usize, from: usize, accelerations: &[f64], factor: f64) {
    let (mut speed, mut displacement) = (0.0, 0.0);
    for (index, tick) in ticks.iter_mut().enumerate().skip(from) {
        speed += factor * accelerations.get(index - from).unwrap_or(&0.0) * STEP_S;
        // Rounding must not remain as a speed.
        if index - from >= accelerations.len() {
            speed = 0.0;
        }
        displacement += speed * STEP_S;
        if tick.command.joint_count > 0 {
            tick.command.position[joint] += displacement;
            tick.command.velocity[joint] += speed;
        }
    }
}

/// Shifts the positions of a joint at once.
fn shift(ticks: &mut [Tick], joint: usize, from: usize, distance: f64) {
    for tick in ticks[from..]
        .iter_mut()
        .filter(|tick| tick.command.joint_count > 0)
    {
        tick.command.position[joint] += distance;
    }
}

fn beyond_limit(ticks: &mut [Tick]) {
    let positions = ticks.iter().map(|tick| tick.command.position[SHOULDER]);
    let highest = positions.fold(f64::MIN, f64::max);
    shift(ticks, SHOULDER, 0, 1.5 + 1e-6 - highest);
}

/// Scales the motion of a joint to a multiple of its speed limit.
fn too_fast(ticks: &mut [Tick], of_limit: f64) {
    let (start, factor) = (
        ticks[RUN - 1].command.position[SHOULDER],
        of_limit * 0.6 / 0.3,
    );
    for tick in ticks.iter_mut().filter(|tick| tick.command.joint_count > 0) {
        let position = &mut tick.command.position[SHOULDER];
        *position = start + factor * (*position - start);
        tick.command.velocity[SHOULDER] *= factor;
    }
}

fn does_not_brake(ticks: &mut Vec<Tick>) {
    ticks.truncate(RESUME);
    let speed = ticks[HOLD - 1].command.velocity[SHOULDER];
    let mut position = ticks[HOLD - 1].command.position[SHOULDER];
    for tick in &mut ticks[HOLD..] {
        position += speed * STEP_S;
        tick.command.position[SHOULDER] = position;
        tick.command.velocity[SHOULDER] = speed;
    }
}

fn drifts(ticks: &mut Vec<Tick>) {
    ticks.truncate(RESUME);
    for (index, tick) in (1..).zip(&mut ticks[HOLD + 30..]) {
        tick.command.position[JAW] += 1e-13 * f64::from(index);
    }
}

/// Opens the jaw by a smooth motion until no fingertip presses the object.
fn opens_hand(ticks: &mut [Tick]) {
    push(ticks, JAW, LIFTED, &[1.0, 0.0, -1.0], 1.0);
    change(&mut ticks[LIFTED + 5..], |object| object.pressed = 0);
}

fn renumber(ticks: &mut [Tick], change: impl Fn(&mut JointCommand)) {
    ticks.iter_mut().for_each(|tick| change(&mut tick.command));
}

/// Delays commands by periods, with their validity.
fn delay(ticks: &mut [Tick], periods: i64) {
    let delay_ns = periods * TICK_NS as i64;
    renumber(ticks, |command| {
        let captured_ns = command.stamp.captured_ns.saturating_add_signed(delay_ns);
        command.stamp.captured_ns = captured_ns;
        command.valid_until_ns = captured_ns + VALID_NS;
    });
}

fn set_mode(ticks: &mut [Tick], mode: Mode) {
    renumber(ticks, |command| command.mode = mode);
}

fn reach(within_ticks: u64) -> Event {
    Event::Promise(Promise::reach(&[Mode::HOLD], within_ticks))
}

fn change(ticks: &mut [Tick], change: impl Fn(&mut ObjectTruth)) {
    let objects = ticks.iter_mut().map(|tick| &mut tick.truth.objects[0]);
    objects.for_each(change);
}

#[test]
fn each_broken_controller_is_rejected() {
    let cases = [NUMBERS, MOTIONS, STAMPS, MODES, WORLDS].concat();
    assert!(cases.len() >= 20);
    for (name, apply, expected) in cases {
        let mut ticks = correct();
        apply(&mut ticks);
        for tick in &mut ticks {
            tick.command.seal();
        }
        let judge = observed(&ticks);
        let first = judge.violations().first();
        let kind = first.map(|violation| violation.kind);
        assert_eq!(kind, Some(expected), "{name}: {:?}", judge.violations());
        assert!(judge.count_of(expected) > 0, "{name}");
    }
}

#[test]
fn damaged_command_is_rejected() {
    let mut ticks = correct();
    ticks[CRUISE].command.position[1] += 1e-9;
    let judge = observed(&ticks);
    let kinds: Vec<_> = judge.violations().iter().map(|it| it.kind).collect();
    assert_eq!(kinds, [ViolationKind::Checksum]);
}
