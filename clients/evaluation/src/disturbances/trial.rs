//! One trial: grasp, lift, hold, disturbance, watch.

use super::applied::Applied;
use super::case::Disturbance;
use super::response::Response;
use crate::held::{Grip, HeldRun, HeldTrial, LIFTED_SHARE};
use atas_client::goal::LIFT_M;
use shm_schemas::ObjectTruth;

/// Time limit for the lift, s. Design choice: three times the usual time.
const LIFT_LIMIT_S: f64 = 40.0;
/// Time from half of the lift to the disturbance, s. Design choice: the lift has ended and the grip
/// has relaxed.
const SETTLE_S: f64 = 6.0;
/// Time from the disturbance to the end, s. Design choice: five times the ramp.
const WATCHED_S: f64 = 5.0;
/// Largest slip of a caught object, m (design choice: as for a successful task).
const CAUGHT_SLIP_M: f64 = 0.003;
/// Length of the average of the force at the end, s. Design choice: several periods of tremor.
const FORCE_S: f64 = 0.5;

/// True outcome after a disturbance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// In the lifted hand, unharmed.
    Kept,
    Crushed,
    Dropped,
    /// Lowered without a drop after the disturbance.
    PutBack,
    /// Not in the lifted hand before the disturbance.
    NotLifted,
    /// The engine could not simulate the trial.
    Discarded,
}

/// End of a trial.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ending {
    pub(super) outcome: Outcome,
    /// Friction could hold the object throughout.
    pub(super) allowed: bool,
    /// F_2 and kinetic friction could stop the sliding object.
    pub(super) catchable: bool,
    /// Slip in the hand since the disturbance, m; `None` unless lifted before.
    pub(super) slip_m: Option<f64>,
    pub(super) slipped: bool,
    pub(super) latency_ms: Option<f64>,
    /// Grip force at the end over the force then needed; `None` unless kept.
    pub(super) over_grip: Option<f64>,
    /// Reason if the engine could not simulate the trial.
    pub(super) discarded: Option<String>,
}

impl Ending {
    /// Returns true for a catchable object that was kept and slid by at most `CAUGHT_SLIP_M`.
    pub(super) fn is_caught(&self) -> bool {
        let slid_little = self.slip_m.is_some_and(|slip_m| slip_m <= CAUGHT_SLIP_M);
        self.catchable && self.outcome == Outcome::Kept && slid_little
    }
}

/// Runs one case with one gripper.
pub(super) fn run(
    trial: &HeldTrial<'_>,
    disturbance: Disturbance,
    grip: Grip,
    seed: u64,
) -> anyhow::Result<Ending> {
    let applied = Applied::new(disturbance, trial, seed);
    let mut ending = Ending {
        outcome: Outcome::NotLifted,
        allowed: applied.is_allowed(&trial.load()),
        catchable: applied.is_catchable(&trial.load()),
        slip_m: None,
        slipped: false,
        latency_ms: None,
        over_grip: None,
        discarded: None,
    };
    let mut run = trial.start(grip)?;
    if run.lift(LIFT_LIMIT_S).is_some() {
        run.hold(SETTLE_S, |_, _| Ok(()))?;
    }
    ending.outcome = match before(&run.object()) {
        Some(outcome) => outcome,
        None => disturb(&mut run, disturbance, &applied, &mut ending)?,
    };
    ending.discarded = run.discarded()?;
    if ending.discarded.is_some() {
        ending = Ending {
            outcome: Outcome::Discarded,
            slip_m: None,
            latency_ms: None,
            over_grip: None,
            slipped: false,
            ..ending
        };
    }
    Ok(ending)
}

/// Applies the disturbance and watches the object.
fn disturb(
    run: &mut HeldRun<'_>,
    disturbance: Disturbance,
    applied: &Applied,
    ending: &mut Ending,
) -> anyhow::Result<Outcome> {
    run.world_mut().restart_slip(0);
    if let Some([height_m, duration_s]) = disturbance.bump() {
        let hand = run.hand();
        run.world_mut().bump(hand, height_m, duration_s)?;
    }
    let mut response = Response::new(run.slid_m(), run.commanded_opening_m());
    let (mut force_sum_n, mut count) = (0.0, 0.0);
    run.hold(WATCHED_S, |run, since_s| {
        run.world_mut().pull(0, applied.force_n(since_s))?;
        response.update(since_s, run.slid_m(), run.commanded_opening_m());
        if since_s >= WATCHED_S - FORCE_S {
            force_sum_n += run.grip_n();
            count += 1.0;
        }
        Ok(())
    })?;
    let object = run.object();
    let outcome = after(&object);
    ending.slip_m = Some(object.slip_in_hand_m);
    ending.slipped = response.has_slipped();
    ending.latency_ms = response.latency_ms();
    let needed_n = applied.needed_n(WATCHED_S);
    if outcome == Outcome::Kept && count > 0.0 && needed_n > 0.0 {
        ending.over_grip = Some(force_sum_n / count / needed_n);
    }
    Ok(outcome)
}

/// Returns the outcome if the object is not held before the disturbance.
fn before(object: &ObjectTruth) -> Option<Outcome> {
    match after(object) {
        Outcome::Kept => None,
        Outcome::PutBack => Some(Outcome::NotLifted),
        harmed => Some(harmed),
    }
}

fn after(object: &ObjectTruth) -> Outcome {
    if object.crushed != 0 {
        Outcome::Crushed
    } else if object.dropped != 0 {
        Outcome::Dropped
    } else if object.lifted_m < LIFTED_SHARE * LIFT_M {
        Outcome::PutBack
    } else {
        Outcome::Kept
    }
}
