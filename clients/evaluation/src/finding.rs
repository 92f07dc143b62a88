//! Evaluation of one trial in the form that reports count and summarise.

use atas_client::GoalProgress;
use atas_client::goal::LIFT_M;
use robot_model::HandModel;
use serde::{Deserialize, Serialize};
use shm_schemas::{GoalState, ObjectTruth, WorldTruth};

use crate::Task;
use crate::judge::{Assembly, HiddenMotion, Load, Outcome, Placing, Screwing, TURN_MAX_RAD};
use crate::offline::Trial;

/// Evaluation of one trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Outcome key as counted in reports: `held`, `dropped`, `refused: too-heavy`.
    pub outcome: String,
    /// True if the task succeeded.
    pub done: bool,
    /// True if refused, with the object unharmed, upright and in place.
    pub refused: bool,
    /// True if an object was crushed.
    pub crushed: bool,
    /// True if an object was dropped.
    pub dropped: bool,
    /// Slide or turn in the hand that the controller reported as success.
    pub hidden: HiddenMotion,
    /// Measured quantities, by name with unit.
    pub measures: Vec<(String, f64)>,
    /// Measured F_2 over F_2 at the true stiffness; `None` without measurement.
    pub f2_ratio: Option<f64>,
}

impl Finding {
    /// Returns the finding of a trial that the engine could not simulate: never a success.
    pub(super) fn discarded(reason: &str) -> Self {
        Self {
            outcome: format!("discarded: {reason}"),
            done: false,
            refused: false,
            crushed: false,
            dropped: false,
            hidden: HiddenMotion::default(),
            measures: Vec::new(),
            f2_ratio: None,
        }
    }

    /// Returns the failure key, or `None` on success. A feasible task must be done, an infeasible
    /// one refused.
    #[must_use]
    pub fn failure(&self, feasible: bool) -> Option<&str> {
        let success = if feasible { self.done } else { self.refused };
        (!success).then_some(self.outcome.as_str())
    }

    /// Returns the measured quantity with this name.
    #[must_use]
    pub fn measure(&self, name: &str) -> Option<f64> {
        let found = self.measures.iter().find(|(known, _)| known == name);
        found.map(|(_, value)| *value)
    }
}

pub(super) fn evaluate(
    task: Task,
    hand: &HandModel,
    trial: &Trial,
    progress: &GoalProgress,
    load: Load,
    to_m: [f64; 2],
) -> Finding {
    let Trial {
        end, start, truth, ..
    } = trial;
    let objects = &truth.objects[..truth.object_count as usize];
    let happened = |what: fn(&ObjectTruth) -> u32| objects.iter().any(|o| what(o) != 0);
    let outcome = Outcome::evaluate(end, truth, hand, LIFT_M);
    let mut hidden = HiddenMotion::evaluate(end, truth);
    let (failure, done, mut measures) = match task {
        Task::Grasp => (
            (outcome != Outcome::Held).then(|| outcome.key(end.step.as_str())),
            "held",
            over_grip_measures(outcome, hand, truth, load),
        ),
        Task::PickPlace => {
            let placing = Placing::evaluate(end, truth, to_m, progress.released_ns());
            let measures = placing_measures(&placing);
            (placing.failure, "placed", measures)
        }
        Task::Screw => {
            let screwing = Screwing::evaluate(end, truth);
            let turned = ("turned", screwing.turned);
            let measures = vec![("tightness", screwing.tightness), turned];
            (screwing.failure, "tight", measures)
        }
        Task::Assembly => {
            let assembly = Assembly::evaluate(end, start, truth);
            let stood_still = assembly.turned_rad.abs() <= TURN_MAX_RAD;
            hidden.turned |= !stood_still && end.state == GoalState::SUCCEEDED;
            let measures = vec![
                ("tightness", assembly.tightness),
                ("tilt_deg", assembly.tilt_rad.to_degrees()),
                ("bottle_turn_deg", assembly.turned_rad.abs().to_degrees()),
            ];
            (assembly.failure, "closed, standing", measures)
        }
    };
    let most = |what: fn(&ObjectTruth) -> f64| objects.iter().map(what).fold(0.0, f64::max);
    measures.push(("slip_mm", most(|o| o.slip_in_hand_m) * 1e3));
    measures.push(("turn_deg", most(|o| o.turn_in_hand_rad).to_degrees()));
    let felt_f2 = task == Task::Grasp && end.figures.stiffness_n_m > 0.0;
    Finding {
        done: failure.is_none(),
        outcome: failure.unwrap_or_else(|| done.to_owned()),
        refused: matches!(outcome, Outcome::Refused(_)),
        crushed: happened(|o| o.crushed),
        dropped: happened(|o| o.dropped),
        hidden,
        measures: measures.into_iter().map(named).collect(),
        f2_ratio: felt_f2.then(|| f64::from(end.figures.f2_n) / load.f2_n),
    }
}

fn named((name, value): (&str, f64)) -> (String, f64) {
    (name.to_owned(), value)
}

fn placing_measures(placing: &Placing) -> Vec<(&'static str, f64)> {
    vec![
        ("off_mm", placing.off_m * 1e3),
        ("latency_ms", placing.latency_s * 1e3),
        ("parting_ms", placing.parting_s * 1e3),
        ("pressed_down_n", placing.pressed_down_n),
        ("released_above_mm", placing.released_above_m * 1e3),
    ]
}

/// Returns over-grip ratios: mean true normal force per side over the force against sliding, for
/// domes also against rotation.
fn over_grip_measures(
    outcome: Outcome,
    hand: &HandModel,
    truth: &WorldTruth,
    load: Load,
) -> Vec<(&'static str, f64)> {
    if !matches!(outcome, Outcome::Held | Outcome::Slipped | Outcome::Turned) {
        return Vec::new();
    }
    let normal_n = &truth.normal_n[hand.side().index()];
    let mean_n = hand.grasp_sides().mean_sum(|fingertip| normal_n[fingertip]);
    let mut measures = vec![("over_grip", mean_n / load.needed_n)];
    if hand.skin().layout.is_dome() {
        measures.push(("over_steady", mean_n / load.gripped_n));
    }
    measures
}
