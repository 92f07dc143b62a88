//! Grasp demo: the object is held if physically possible, otherwise put back undamaged.

use atas_client::goal::LIFT_M;
use atas_console::arguments::DemoOptions;
use atas_tasks::Task;
use atas_tasks::judge::Outcome;
use robot_model::HandModel;
use serde_json::Value;
use shm_schemas::{Cause, GoalRequest, GraspFigures, WorldTruth};
use sim_backend::Object;

use crate::Setting;
use crate::observed::ObservedRun;
use crate::scenario::{Evaluation, Figure, Scenario, finite};

pub(crate) struct Grasp {
    argument: String,
    set: Setting,
}

impl Grasp {
    pub(crate) fn new(argument: &str, running: &DemoOptions) -> anyhow::Result<Self> {
        Ok(Self {
            argument: argument.to_owned(),
            set: Setting::from_task(Task::Grasp, running, crate::object(argument)?)?,
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

    fn scene_arguments(&self) -> Vec<String> {
        vec!["--object".into(), self.argument.clone()]
    }

    fn goal(&self) -> GoalRequest {
        self.set.goal
    }

    fn hand(&self) -> &HandModel {
        self.set.hand()
    }

    fn progress_text(&self, truth: &WorldTruth) -> String {
        crate::lifted(truth)
    }

    fn evaluate(&self, observed: &ObservedRun) -> Evaluation {
        let hand = self.set.hand();
        let load = self.set.load();
        let outcome = Outcome::evaluate(observed.progress.last(), &observed.truth, hand, LIFT_M);
        let object = &observed.truth.objects[0];
        let mut figures = vec![
            Figure::new("needed N", "needed_n", load.needed_n, 2),
            Figure::json_only("crush_n", finite(load.crush_n)),
            Figure::json_only("feasible", load.is_feasible()),
        ];
        figures.extend(grip_figures(observed.progress.figures(), self.set.hand()));
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
        figures.push(Figure::json_only("took_s", observed.progress.took_s()));
        Evaluation {
            figures,
            outcome: outcome.name().to_owned(),
            cause: refusal_cause(outcome),
            expected: if load.is_feasible() {
                "held"
            } else {
                "refused"
            },
            as_expected: outcome.is_expected(load.is_feasible()),
        }
    }
}

pub(crate) fn refusal_cause(outcome: Outcome) -> Option<Cause> {
    match outcome {
        Outcome::Refused(cause) => Some(cause),
        _ => None,
    }
}

/// Returns the controller's estimates and the normal forces of the hand's fingertips.
pub(crate) fn grip_figures(figures: &GraspFigures, hand: &HandModel) -> Vec<Figure> {
    let sides = hand.grasp_sides();
    let pressed_n = &figures.normal_n[..sides.fingertip_count()];
    let mean_n = sides.mean_sum(|fingertip| pressed_n[fingertip].into()) as f32;
    let shown = |head, key, value: f32, digits| Figure::new(head, key, value.into(), digits);
    vec![
        Figure {
            value: pressed_n
                .iter()
                .map(|force_n| Value::from(*force_n))
                .collect(),
            ..shown("F_n N", "normal_n", mean_n, 2)
        },
        Figure::json_only("f1_n", figures.f1_n),
        shown("F_2 N", "f2_n", figures.f2_n, 2),
        shown("stiffness N/m", "stiffness_n_m", figures.stiffness_n_m, 0),
    ]
}
