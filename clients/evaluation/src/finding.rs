//! What a trial found: the judgement of its task, as reports count and measure it.

use atas_client::GoalProgress;
use atas_client::goal::LIFT_M;
use shm_schemas::GoalUpdate;

use crate::judge::{Assembly, Load, Outcome, Placing, Screwing};
use crate::offline::Trial;
use crate::task::{SIDE, Task};

/// The judgement of one trial.
#[derive(Clone, Debug, PartialEq)]
pub enum Finding {
    /// Of a grasp.
    Grasp(Grasped),
    /// Of a pick and place.
    PickPlace(Placing),
    /// Of a screwing.
    Screw(Screwing),
    /// Of an assembly.
    Assembly(Assembly),
}

/// What became of a grasp.
#[derive(Clone, Debug, PartialEq)]
pub struct Grasped {
    /// What physics says of this member of the family.
    pub load: Load,
    /// What truly became of it.
    pub outcome: Outcome,
    /// Why it is no success; `None` if it ended as physics says it should.
    pub failure: Option<String>,
    /// Mean true normal force of the fingers at the end over the force needed; of held objects only.
    pub over_grip: Option<f64>,
    /// F_2 that the controller measured over F_2 at the true stiffness; `None` if it never got so far.
    pub f2_ratio: Option<f64>,
    /// How far the object slid on a fingertip, the farther of the two, m; of held objects only.
    pub slip_m: Option<f64>,
}

impl Finding {
    /// Why the trial is no success; `None` if it is.
    #[must_use]
    pub fn failure(&self) -> Option<&str> {
        match self {
            Self::Grasp(grasped) => grasped.failure.as_deref(),
            Self::PickPlace(placing) => placing.failure.as_deref(),
            Self::Screw(screwing) => screwing.failure.as_deref(),
            Self::Assembly(assembly) => assembly.failure.as_deref(),
        }
    }

    /// What was measured, by names with units.
    pub(super) fn measures(&self) -> Vec<(&'static str, f64)> {
        match self {
            Self::Grasp(grasped) => {
                let over_grip = grasped.over_grip.map(|ratio| ("over_grip", ratio));
                let slip = grasped.slip_m.map(|slip_m| ("slip_mm", slip_m * 1e3));
                over_grip.into_iter().chain(slip).collect()
            }
            Self::PickPlace(placing) => vec![
                ("off_mm", placing.off_m * 1e3),
                ("latency_ms", placing.latency_s * 1e3),
                ("parting_ms", placing.parting_s * 1e3),
                ("released_above_mm", placing.released_above_m * 1e3),
            ],
            Self::Screw(screwing) => vec![
                ("tightness", screwing.tightness),
                ("turned", screwing.turned),
            ],
            Self::Assembly(assembly) => vec![
                ("tightness", assembly.tightness),
                ("tilt_deg", assembly.tilt_rad.to_degrees()),
            ],
        }
    }

    /// The judgement of a grasp, if it was one.
    pub(super) fn grasped(&self) -> Option<&Grasped> {
        match self {
            Self::Grasp(grasped) => Some(grasped),
            _ => None,
        }
    }
}

/// The judgement of a trial of a task with a place at `to_m`.
pub(super) fn judge(
    task: Task,
    trial: &Trial,
    progress: &GoalProgress,
    load: Load,
    to_m: [f64; 2],
) -> Finding {
    let (end, truth) = (&trial.end, &trial.truth);
    match task {
        Task::Grasp => Finding::Grasp(grasped(trial, load)),
        Task::PickPlace => Finding::PickPlace(Placing::of(end, truth, to_m, progress.let_go_ns())),
        Task::Screw => Finding::Screw(Screwing::of(end, truth)),
        Task::Assembly => Finding::Assembly(Assembly::of(end, &trial.start, truth)),
    }
}

fn grasped(trial: &Trial, load: Load) -> Grasped {
    let (end, truth): (&GoalUpdate, _) = (&trial.end, &trial.truth);
    let (hand, fingers) = (SIDE.index(), ..robot_model::FINGERS);
    let outcome = Outcome::of(end, truth, hand, LIFT_M);
    let pressed_n = &truth.normal_n[hand][fingers];
    let mean_n = pressed_n.iter().sum::<f64>() / pressed_n.len() as f64;
    let slips_m = truth.slip_m[hand][fingers].iter();
    let slip_m = slips_m.fold(0.0, |farthest: f64, slip_m| farthest.max(*slip_m));
    let is_held = outcome == Outcome::Held;
    let measured_f2 = end.figures.stiffness_n_m > 0.0;
    let unexpected = !outcome.is_expected(load.is_feasible());
    Grasped {
        load,
        outcome,
        failure: unexpected.then(|| outcome.key(end.step.as_str())),
        over_grip: is_held.then_some(mean_n / load.needed_n),
        f2_ratio: measured_f2.then(|| f64::from(end.figures.f2_n) / load.f2_n),
        slip_m: is_held.then_some(slip_m),
    }
}
