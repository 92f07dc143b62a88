//! Random events of an episode.

use atas_core::Settings;
use atas_core::settings::PARAMETERS;
use sim_backend::random::Random;

use crate::catalogue::{CATALOGUE, Evidence};
use crate::injection::Injection;

/// Longest pause of the controller, ticks.
const PAUSE_MAX_TICKS: f64 = 400.0;
/// Longest fault of sensors or joints, s.
const FAULT_MAX_S: f64 = 0.5;
/// Largest relative change of a parameter. Design choice: a user's adjustment; the limits of
/// larger ones belong to the configuration check.
const CHANGE_MAX: f64 = 0.1;
/// Largest error of a further goal's position, m.
const GOAL_ERROR_M: f64 = 0.003;

/// Event at a tick.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Event {
    pub(super) tick: u64,
    pub(super) kind: EventKind,
}

/// Kind of an event.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum EventKind {
    /// Fault of the acting hand's frames or of the joints, as for `atas-sim --fault`.
    Fault(String),
    /// The controller does not run for this number of ticks.
    Pause(u64),
    /// A new controller begins after this number of ticks.
    Restart(u64),
    /// A user stops the robot.
    Stop,
    /// A user ends the stop.
    Recover,
    /// The daemon holds for one tick.
    Hold,
    /// The client cancels its goal.
    Cancel,
    /// The client of the goal disappears.
    Disconnect,
    /// A client sends the goal of the task again, with this position error, m.
    Goal([f64; 2]),
    /// A user changes a parameter.
    Parameter(usize, f64),
    /// A user takes the present reading of a hand as zero.
    Bias(usize),
}

impl Event {
    /// Returns a random event.
    pub(super) fn random(random: &mut Random, ticks: u64, hand: &str, settings: &Settings) -> Self {
        let tick = 1 + random.bits() % ticks.max(1);
        let mut pause = || 1 + random.between(0.0, PAUSE_MAX_TICKS) as u64;
        let (short, long) = (pause(), pause());
        let kind = match random.bits() % 12 {
            0..=2 => EventKind::Fault(fault(random, tick, hand)),
            3 => EventKind::Pause(short.div_ceil(20)),
            4 => EventKind::Pause(long),
            5 => EventKind::Restart(long),
            6 => EventKind::Stop,
            7 => EventKind::Recover,
            8 => EventKind::Hold,
            9 => match random.chance(0.5) {
                true => EventKind::Cancel,
                false => EventKind::Disconnect,
            },
            10 => {
                let mut error_m = || random.between(-GOAL_ERROR_M, GOAL_ERROR_M);
                EventKind::Goal([error_m(), error_m()])
            }
            _ => parameter(random, settings),
        };
        Self { tick, kind }
    }
}

/// Returns a random fault of the catalogue with a random length.
fn fault(random: &mut Random, tick: u64, hand: &str) -> String {
    let faults: Vec<(&str, bool)> = CATALOGUE
        .iter()
        .filter_map(|fault| match fault.evidence {
            Evidence::Injected(Injection::Frames(kind, _), _) => Some((kind, false)),
            Evidence::Injected(Injection::Joints(kind, _), _) => Some((kind, true)),
            _ => None,
        })
        .collect();
    let (kind, is_of_joints) = faults[random.bits() as usize % faults.len()];
    let target = if is_of_joints { "joints" } else { hand };
    let length_s = random.between(0.001, FAULT_MAX_S);
    format!("{kind}@{}+{length_s}:{target}", tick as f64 * 1e-3)
}

/// Returns a small change of a parameter that is valid for these settings.
fn parameter(random: &mut Random, settings: &Settings) -> EventKind {
    let index = random.bits() as usize % PARAMETERS.len();
    let parameter = &PARAMETERS[index];
    let change = 1.0 + random.between(-CHANGE_MAX, CHANGE_MAX);
    let value = ((parameter.get)(settings) * change).clamp(parameter.lower, parameter.upper);
    let mut changed = *settings;
    // The daemon changes values of the safety gate only while the robot is stopped.
    let is_safety = parameter.name.starts_with("safety.");
    match is_safety || changed.set(parameter.name, value).is_err() {
        true => EventKind::Bias(index % 2),
        false => EventKind::Parameter(index, value),
    }
}
