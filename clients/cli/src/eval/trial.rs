//! One trial: a member of an object's family, a world around it, a goal from nominal knowledge, and the judgement.

use anyhow::Context;
use robot_model::{RobotModel, Side};
use rustix::time::{ClockId, clock_gettime};
use shm_schemas::Text;
use shm_schemas::layout::{FNV_OFFSET, fnv1a};
use sim_backend::Scene;
use sim_backend::random::split_mix;

use super::Plan;
use crate::arguments::{HOLD_S, LIFT_MM};
use crate::judge::{Load, Outcome};
use crate::rehearsal::{Rehearsal, grasp_goal};

/// The hand that grasps.
const SIDE: Side = Side::Right;
/// Longest simulated time of a trial, s (ours: ten times what a clean grasp takes).
const LIMIT_S: f64 = 120.0;

/// The judgement of one trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// Index of the object in the plan.
    pub object: usize,
    /// What physics says of this member of the family.
    pub load: Load,
    /// What truly became of it.
    pub outcome: Outcome,
    /// The controller's step at the end.
    pub step: Text<16>,
    /// Mean true normal force of the fingers at the end over the force needed; of held objects only.
    pub over_grip: Option<f64>,
    /// F_2 that the controller measured over F_2 at the true stiffness; `None` if it never got so far.
    pub f2_ratio: Option<f64>,
    /// How far the object slid on a fingertip, the farther of the two, m; of held objects only.
    pub slip_m: Option<f64>,
    /// Simulated time, s.
    pub simulated_s: f64,
    /// Processor time of this thread, s. The only field that is not a function of the plan.
    pub cpu_s: f64,
}

/// The seed of a trial: a function of the object's name and the trial's number, so that adding an object to a plan
/// changes no other trial.
#[must_use]
pub fn trial_seed(object: &str, seed: u64) -> u64 {
    split_mix(fnv1a(FNV_OFFSET, object.as_bytes()) ^ split_mix(seed))
}

pub(super) fn run(
    robot: &RobotModel,
    plan: &Plan,
    object: usize,
    number: u64,
) -> anyhow::Result<Record> {
    let begin_s = cpu_s();
    let nominal = &plan.objects[object];
    let seed = trial_seed(&nominal.name, number);
    let mut scene = Scene::grasp(nominal.clone(), SIDE).varied(seed);
    scene.noise_factor = plan.noise;
    scene.sensor_rate_hz = [plan.rate_hz; 2];
    let hint = scene
        .grasp_hint(0)
        .context("the scene of a grasp has an object")?;
    let load = Load::of(&scene.objects[0].object, &plan.settings.grasp);
    let lift_m = LIFT_MM * 1e-3;
    let mut rehearsal = Rehearsal::new(robot, &scene, seed, plan.settings)?;
    let trial = rehearsal.run(&grasp_goal(&hint, SIDE, lift_m, HOLD_S), LIMIT_S, |_, _| {});
    if let Some(fault) = rehearsal.world().fault() {
        return Err(fault).with_context(|| format!("object {:?}, seed {number}", nominal.name));
    }
    let hand = SIDE.index();
    let fingers = ..robot_model::FINGERS;
    let outcome = Outcome::of(&trial.end, &trial.truth, hand, lift_m);
    let pressed_n = &trial.truth.normal_n[hand][fingers];
    let mean_n = pressed_n.iter().sum::<f64>() / pressed_n.len() as f64;
    let slip_m = trial.truth.slip_m[hand][fingers]
        .iter()
        .fold(0.0, |farthest: f64, slip_m| farthest.max(*slip_m));
    let is_held = outcome == Outcome::Held;
    let measured_f2 = trial.end.figures.hardness_n_m > 0.0;
    Ok(Record {
        object,
        load,
        outcome,
        step: trial.end.step,
        over_grip: is_held.then_some(mean_n / load.needed_n),
        f2_ratio: measured_f2.then(|| f64::from(trial.end.figures.f2_n) / load.f2_n),
        slip_m: is_held.then_some(slip_m),
        simulated_s: trial.simulated_s,
        cpu_s: cpu_s() - begin_s,
    })
}

/// Processor time of this thread, s.
fn cpu_s() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}
