//! One trial: grasp, lift and hold, with the forces and deformations that occur.

use serde::Serialize;

use crate::held::{Grip, HeldTrial, Outcome};

/// Time limit for the lift, s. Design choice: three times the usual time.
const LIFT_LIMIT_S: f64 = 40.0;
/// Duration of the watch after half of the lift, s. Design choice: the grip has relaxed.
const WATCHED_S: f64 = 8.0;

/// End of a trial.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ending {
    pub(super) outcome: Outcome,
    pub(super) figures: Figures,
    /// Reason if the engine could not simulate the trial.
    pub(super) discarded: Option<String>,
}

/// Measured quantities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Figures {
    /// Largest force of a fingertip over the force that friction needs.
    pub(super) peak: f64,
    /// Largest compression of the object by a fingertip, m.
    pub(super) deformation_m: f64,
    /// Mean force per side at the end over the force that friction needs.
    pub(super) over_grip: f64,
    pub(super) slip_m: f64,
    /// Time from the start until the object is lifted by half, s.
    pub(super) lifted_s: Option<f64>,
}

/// Runs one gripper; `noise` is the factor on the sensor noise.
pub(super) fn run(trial: &HeldTrial<'_>, grip: Grip, noise: f64) -> anyhow::Result<Ending> {
    let trial = trial.with_scene(|scene| scene.noise_factor = noise);
    let mut run = trial.start(grip)?;
    let begin_s = run.now_s();
    let lifted_s = run.lift(LIFT_LIMIT_S);
    if lifted_s.is_some() {
        run.hold(WATCHED_S, |_, _| Ok(()))?;
    }
    let (truth, needed_n) = (run.object(), trial.load().needed_n);
    let discarded = run.discarded()?;
    Ok(Ending {
        outcome: match discarded {
            None => Outcome::of(&truth),
            Some(_) => Outcome::Discarded,
        },
        figures: Figures {
            peak: truth.max_force_n / needed_n,
            deformation_m: truth.max_force_n / trial.object().stiffness_n_m,
            over_grip: run.grip_n() / needed_n,
            slip_m: truth.slip_in_hand_m,
            lifted_s: lifted_s.map(|lifted_s| lifted_s - begin_s),
        },
        discarded,
    })
}
