//! Grasp demo: the object is held if physically possible, otherwise put back undamaged.

use atas_client::goal::LIFT_M;
use atas_console::arguments::Running;
use atas_evaluation::Task;
use atas_evaluation::judge::Outcome;
use robot_model::VIRTUAL_FINGERS;
use serde_json::Value;
use shm_schemas::{Cause, GoalRequest, GraspFigures, WorldTruth};
use sim_backend::Object;

use super::Setting;
use super::scenario::{Figure, Judged, Scenario, finite};
use super::seen::Seen;

pub(super) struct Grasp {
    argument: String,
    set: Setting,
}

impl Grasp {
    pub(super) fn new(argument: &str, running: &Running) -> anyhow::Result<Self> {
        Ok(Self {
            argument: argument.to_owned(),
            set: Setting::of(Task::Grasp, running, super::object(argument)?)?,
        })
    }

    fn object(&self) -> &Object {
        self.set.object()
    }
}

impl Scenario for Grasp {
    fn name(&self) -> &str {
        &self.object().name
    }

    fn setting(&self) -> Vec<String> {
        vec!["--object".into(), self.argument.clone()]
    }

    fn goal(&self) -> GoalRequest {
        self.set.goal
    }

    fn live(&self, truth: &WorldTruth) -> String {
        super::lifted(truth)
    }

    fn judge(&self, seen: &Seen) -> Judged {
        let hand = self.set.hand();
        let load = self.set.load();
        let outcome = Outcome::of(seen.progress.last(), &seen.truth, hand, LIFT_M);
        let object = &seen.truth.objects[0];
        let mut figures = vec![
            Figure::new("needed N", "needed_n", load.needed_n, 2),
            Figure::hidden("crush_n", finite(load.crush_n)),
            Figure::hidden("feasible", load.is_feasible()),
        ];
        figures.extend(gripped(seen.progress.figures(), self.set.fingers));
        figures.push(Figure::new(
            "slip mm",
            "slip_mm",
            object.slip_in_hand_m * 1e3,
            2,
        ));
        figures.push(Figure::new(
            "lifted mm",
            "lifted_mm",
            object.lifted_m * 1e3,
            1,
        ));
        // Not in the table: all grasps take a similar time, and the table is full.
        figures.push(Figure::hidden("took_s", seen.progress.took_s()));
        Judged {
            figures,
            outcome: outcome.name().to_owned(),
            cause: refused_for(outcome),
            should: if load.is_feasible() {
                "held"
            } else {
                "refused"
            },
            as_expected: outcome.is_expected(load.is_feasible()),
        }
    }
}

pub(super) fn refused_for(outcome: Outcome) -> Option<Cause> {
    match outcome {
        Outcome::Refused(cause) => Some(cause),
        _ => None,
    }
}

/// Returns the controller's estimates and the normal forces of the first `fingers` fingertips.
pub(super) fn gripped(figures: &GraspFigures, fingers: usize) -> Vec<Figure> {
    let pressed_n = &figures.normal_n[..fingers];
    // Mean over the two grasp sides; a side may have several fingertips.
    let mean_n = pressed_n.iter().sum::<f32>() / VIRTUAL_FINGERS as f32;
    let shown = |head, key, value: f32, digits| Figure::new(head, key, value.into(), digits);
    vec![
        Figure {
            value: pressed_n
                .iter()
                .map(|force_n| Value::from(*force_n))
                .collect(),
            ..shown("F_n N", "normal_n", mean_n, 2)
        },
        Figure::hidden("f1_n", figures.f1_n),
        shown("F_2 N", "f2_n", figures.f2_n, 2),
        shown("stiffness N/m", "stiffness_n_m", figures.stiffness_n_m, 0),
    ]
}
