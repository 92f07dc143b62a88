//! Pick-and-place demo: within 5 mm of the target, released while standing; an object that is too
//! heavy is put back.

use atas_client::goal::LIFT_M;
use atas_console::arguments::DemoOptions;
use atas_tasks::Task;
use atas_tasks::judge::{Outcome, Placing};
use robot_model::HandModel;
use shm_schemas::{GoalRequest, WorldTruth};
use sim_backend::Object;

use crate::Setting;
use crate::grasp::{grip_figures, refusal_cause};
use crate::observed::ObservedRun;
use crate::scenario::{Evaluation, Figure, Scenario};

pub(crate) struct PickPlace {
    argument: String,
    set: Setting,
}

impl PickPlace {
    pub(crate) fn new(argument: &str, running: &DemoOptions) -> anyhow::Result<Self> {
        Ok(Self {
            argument: argument.to_owned(),
            set: Setting::from_task(Task::PickPlace, running, crate::object(argument)?)?,
        })
    }

    fn object(&self) -> &Object {
        self.set.object()
    }
}

impl Scenario for PickPlace {
    fn name(&self) -> &str {
        &self.object().name
    }

    fn scene_arguments(&self) -> Vec<String> {
        ["--scene", "pick-place", "--object", &self.argument]
            .map(str::to_owned)
            .to_vec()
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
        let [x_m, y_m, _] = self.set.goal.to_m;
        let result = observed.progress.last();
        let placing = Placing::evaluate(
            result,
            &observed.truth,
            [x_m, y_m],
            observed.progress.released_ns(),
        );
        let feasible = self.set.load().is_feasible();
        let outcome = Outcome::evaluate(result, &observed.truth, self.set.hand(), LIFT_M);
        let refused = !feasible && outcome.is_expected(feasible);
        let mut figures = grip_figures(observed.progress.figures(), self.set.hand());
        figures.extend([
            Figure::new("off mm", "off_mm", placing.off_m * 1e3, 1),
            Figure::new(
                "released after ms",
                "released_after_ms",
                placing.latency_s * 1e3,
                1,
            ),
            Figure::new(
                "parted after ms",
                "parted_after_ms",
                placing.parting_s * 1e3,
                1,
            ),
            Figure::new(
                "above mm",
                "released_above_mm",
                placing.released_above_m * 1e3,
                2,
            ),
            Figure::duration(observed),
        ]);
        let word = match &placing.failure {
            Some(_) if refused => "refused".to_owned(),
            Some(failure) => failure.clone(),
            None => "placed".to_owned(),
        };
        Evaluation {
            figures,
            outcome: word,
            cause: refusal_cause(outcome).filter(|_| refused),
            expected: if feasible { "placed" } else { "refused" },
            as_expected: refused || (feasible && placing.failure.is_none()),
        }
    }
}
