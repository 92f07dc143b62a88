//! Command stream of a correct controller, with the world and the events of a test.
//!
//! * INIT, ticks 0 to 19: no joints.
//! * READY, ticks 20 to 39: rest.
//! * RUN, ticks 40 to 199: accelerates, then constant speed.
//! * HOLD, ticks 200 to 299: brakes, then rests.
//! * RUN, ticks 300 to 449: accelerates, lifts the object, brakes.
//! * READY, ticks 450 to 499: rest.
//! * SAFE_STOP, ticks 500 to 559: rest.
//! * HOLD, ticks 560 to 599: rest, after a recovery.
//! * READY, ticks 600 to 619: rest.
//! * INIT, ticks 620 to 639: new process, no joints.
//! * READY, ticks 640 to 659: rest.
//! * FAULT, ticks 660 to 699: rest.

use atas_judge::{JointBounds, JointUnit, Judge, Promise};
use shm_schemas::{JointCommand, Mode, ObjectTruth, Stamp, Text, WorldTruth};

/// Tick period, ns.
pub(crate) const TICK_NS: u64 = 1_000_000;
/// Validity of a command, ns.
pub(crate) const VALID_NS: u64 = 5_000_000;
/// Tick period, s.
pub(crate) const STEP_S: f64 = 1e-3;
/// Index of the first command.
pub(crate) const BEGIN: usize = 0;
/// First command of the first motion.
pub(crate) const RUN: usize = 40;
/// First command with constant speed.
pub(crate) const CRUISE: usize = 100;
/// First command of HOLD.
pub(crate) const HOLD: usize = 200;
/// First command after HOLD.
pub(crate) const RESUME: usize = 300;
/// Command with the object in the hand.
pub(crate) const LIFTED: usize = 350;
/// First command of SAFE_STOP.
pub(crate) const STOP: usize = 500;
/// First command after the recovery.
pub(crate) const RECOVERED: usize = 560;
/// First command of the second process.
pub(crate) const RESTART: usize = 620;
/// First command of the second process with joints.
pub(crate) const AGAIN: usize = 640;
/// First command of FAULT.
pub(crate) const FAULT: usize = 660;
/// Number of commands.
pub(crate) const END: usize = 700;

/// Starts, speeds and limits of the joints: two revolute ones and a jaw.
const START: [f64; 3] = [0.3, -0.9, 0.02];
const SPEED: [f64; 3] = [0.3, -0.25, 0.02];

/// Event before a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Event {
    Restarted,
    RecoverRequested,
    Promise(Promise),
    ExpectGrip,
    ReleaseGrip,
}

/// One tick: events, command and world.
#[derive(Clone, Debug)]
pub(crate) struct Tick {
    pub(crate) events: Vec<Event>,
    pub(crate) command: JointCommand,
    pub(crate) truth: WorldTruth,
}

pub(crate) fn bounds() -> Vec<JointBounds> {
    let revolute = |name: &str| JointBounds {
        name: name.to_owned(),
        unit: JointUnit::Radian,
        lower: -1.5,
        upper: 1.5,
        speed_max: 0.6,
        acceleration_max: 60.0,
        jerk_max: 30_000.0,
    };
    let jaw = JointBounds {
        name: "jaw".to_owned(),
        unit: JointUnit::Metre,
        lower: 0.0,
        upper: 0.05,
        speed_max: 0.2,
        acceleration_max: 6.0,
        jerk_max: 3_000.0,
    };
    vec![revolute("shoulder"), revolute("elbow"), jaw]
}

/// Returns a judge of the reference controller.
pub(crate) fn judge() -> Judge {
    Judge::new(bounds(), TICK_NS, VALID_NS).expect("valid bounds")
}

/// Lets a new judge observe a stream.
pub(crate) fn observed(ticks: &[Tick]) -> Judge {
    let mut judge = judge();
    observe(&mut judge, ticks);
    judge
}

/// Lets a judge observe a stream to its end.
pub(crate) fn observe(judge: &mut Judge, ticks: &[Tick]) {
    for tick in ticks {
        for event in &tick.events {
            match event {
                Event::Restarted => judge.restarted(),
                Event::RecoverRequested => judge.recover_requested(),
                Event::Promise(promise) => judge.promise(*promise),
                Event::ExpectGrip => judge.expect_grip_kept(0).expect("a lifted object"),
                Event::ReleaseGrip => judge.release_grip(),
            }
        }
        judge.observe(&tick.command, &tick.truth);
    }
    judge.finish();
}

fn mode(index: usize) -> Mode {
    match index {
        ..20 | RESTART..AGAIN => Mode::INIT,
        RUN..HOLD | RESUME..450 => Mode::RUN,
        HOLD..RESUME | RECOVERED..600 => Mode::HOLD,
        STOP..RECOVERED => Mode::SAFE_STOP,
        FAULT.. => Mode::FAULT,
        _ => Mode::READY,
    }
}

/// Returns the share of the full speed: smooth ramps of 50 ticks up and 30 ticks down.
fn speed_share(index: usize) -> f64 {
    let up = |from: usize| smooth_step((index as f64 + 1.0 - from as f64) / 50.0);
    let down = |from: usize| 1.0 - smooth_step((index as f64 + 1.0 - from as f64) / 30.0);
    match index {
        RUN..HOLD => up(RUN),
        HOLD..RESUME => down(HOLD),
        RESUME..390 => up(RESUME),
        390..450 => down(390),
        _ => 0.0,
    }
}

fn smooth_step(share: f64) -> f64 {
    let share = share.clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// Returns the stream of the correct controller.
pub(crate) fn correct() -> Vec<Tick> {
    let mut position = START;
    (0..END)
        .map(|index| {
            let speed = SPEED.map(|speed| speed * speed_share(index));
            for (position, speed) in position.iter_mut().zip(speed) {
                *position += speed * STEP_S;
            }
            Tick {
                events: events(index),
                command: command(index, &position, &speed),
                truth: world(index),
            }
        })
        .collect()
}

fn events(index: usize) -> Vec<Event> {
    match index {
        HOLD => vec![Event::Promise(Promise::reach(&[Mode::HOLD], 0))],
        RESUME => vec![Event::Promise(Promise::avoid(&[Mode::HOLD], 100))],
        LIFTED => vec![Event::ExpectGrip],
        RECOVERED => vec![Event::RecoverRequested],
        RESTART => vec![Event::Restarted],
        FAULT => vec![Event::ReleaseGrip],
        _ => Vec::new(),
    }
}

fn command(index: usize, position: &[f64; 3], speed: &[f64; 3]) -> JointCommand {
    let begin = if index < RESTART { BEGIN } else { RESTART };
    let captured_ns = 1_000_000_000 + index as u64 * TICK_NS;
    let mode = mode(index);
    let mut command = JointCommand {
        stamp: Stamp {
            sequence: (index - begin) as u64,
            captured_ns,
            writer_epoch: 7 + begin as u64,
        },
        valid_until_ns: captured_ns + VALID_NS,
        tick: (index - begin) as u64,
        mode,
        ..JointCommand::default()
    };
    if mode != Mode::INIT {
        command.joint_count = 3;
        command.position[..3].copy_from_slice(position);
        command.velocity[..3].copy_from_slice(speed);
    }
    command.seal();
    command
}

fn world(index: usize) -> WorldTruth {
    let is_lifted = index >= 340;
    let object = ObjectTruth {
        name: Text::new("cup"),
        lifted_m: if is_lifted { 0.05 } else { 0.0 },
        slip_in_hand_m: if is_lifted { 0.001 } else { 0.0 },
        crush_n: 8.0,
        pressed: is_lifted.into(),
        ..ObjectTruth::default()
    };
    let mut truth = WorldTruth {
        object_count: 1,
        ..WorldTruth::default()
    };
    truth.objects[0] = object;
    truth
}
