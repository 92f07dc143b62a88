//! One grasp with a long hold, under one sensor model.

use sim_backend::SensorModel;

use crate::held::{Grip, HeldTrial, Outcome};
use crate::policy::GripPolicy;

/// Duration of the watch after the lift, s (acceptance criterion).
const WATCHED_S: f64 = 60.0;
/// Time limit for the lift, s. Design choice: three times the usual time.
const LIFT_LIMIT_S: f64 = 40.0;

/// End of a trial.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ending {
    pub(super) outcome: Outcome,
    pub(super) warned: bool,
    /// Time of the lift from the start of the simulation, s; the limit if it did not happen.
    pub(super) lifted_s: f64,
    /// Reason if the engine could not simulate the trial.
    pub(super) discarded: Option<String>,
}

/// Runs the grasp and watches the object for a minute after the lift.
pub(super) fn run(trial: &HeldTrial<'_>, model: &SensorModel) -> anyhow::Result<Ending> {
    let trial = trial.with_scene(|scene| scene.sensor_model = model.clone());
    let mut run = trial.start(Grip::Policy(GripPolicy::BuiltIn))?;
    let lifted_s = run.lift(LIFT_LIMIT_S);
    if lifted_s.is_some() {
        run.hold(WATCHED_S, |_, _| Ok(()))?;
    }
    let discarded = run.discarded()?;
    Ok(Ending {
        outcome: match discarded {
            None => Outcome::of(&run.object()),
            Some(_) => Outcome::Discarded,
        },
        discarded,
        warned: run.warned(),
        lifted_s: lifted_s.unwrap_or(LIFT_LIMIT_S),
    })
}
