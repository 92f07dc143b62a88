//! Assembly demo: one hand holds the bottle, the other screws the cap tight; the bottle remains
//! upright.

use atas_console::arguments::DemoOptions;
use atas_tasks::Task;
use atas_tasks::judge;
use robot_model::HandModel;
use shm_schemas::{GoalRequest, WorldTruth};

use crate::Setting;
use crate::observed::ObservedRun;
use crate::scenario::{Evaluation, Figure, Scenario};
use crate::screw::{angle_text, screw_figures};

pub(crate) struct Assembly {
    argument: String,
    set: Setting,
}

impl Assembly {
    pub(crate) fn new(argument: &str, running: &DemoOptions) -> anyhow::Result<Self> {
        Ok(Self {
            argument: argument.to_owned(),
            set: Setting::from_task(Task::Assembly, running, crate::cap(argument)?)?,
        })
    }
}

impl Scenario for Assembly {
    fn name(&self) -> &str {
        &self.set.object().name
    }

    fn scene_arguments(&self) -> Vec<String> {
        ["--scene", "assembly", "--cap", &self.argument]
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
        format!("{}, {}", crate::lifted(truth), angle_text(truth))
    }

    fn evaluate(&self, observed: &ObservedRun) -> Evaluation {
        let assembly =
            judge::Assembly::evaluate(observed.progress.last(), &observed.start, &observed.truth);
        let mut figures = screw_figures(observed, assembly.tightness);
        let [cap, bottle, ..] = &observed.truth.objects;
        figures.push(Figure::new(
            "tilt °",
            "bottle_tilt_deg",
            assembly.tilt_rad.to_degrees(),
            2,
        ));
        figures.push(Figure::duration(observed));
        figures.push(Figure::json_only("cap_closed", cap.cap_closed != 0));
        figures.push(Figure::json_only(
            "bottle_stands",
            bottle.table_n > 0.0 && bottle.tipped == 0,
        ));
        Evaluation {
            figures,
            cause: None,
            as_expected: assembly.failure.is_none(),
            outcome: assembly
                .failure
                .unwrap_or_else(|| "closed, standing".to_owned()),
            expected: "closed, standing",
        }
    }
}
