//! Screw demo: the cap is closed and tightened as far as Module 4 requires.

use atas_console::arguments::DemoOptions;
use atas_tasks::Task;
use atas_tasks::judge::Screwing;
use robot_model::HandModel;
use shm_schemas::{GoalRequest, WorldTruth};

use crate::Setting;
use crate::observed::ObservedRun;
use crate::scenario::{Evaluation, Figure, Scenario};

pub(crate) struct Screw {
    argument: String,
    set: Setting,
}

impl Screw {
    pub(crate) fn new(argument: &str, running: &DemoOptions) -> anyhow::Result<Self> {
        Ok(Self {
            argument: argument.to_owned(),
            set: Setting::from_task(Task::Screw, running, crate::cap(argument)?)?,
        })
    }
}

impl Scenario for Screw {
    fn name(&self) -> &str {
        &self.set.object().name
    }

    fn scene_arguments(&self) -> Vec<String> {
        ["--scene", "screw", "--cap", &self.argument]
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
        angle_text(truth)
    }

    fn evaluate(&self, observed: &ObservedRun) -> Evaluation {
        let screwing = Screwing::evaluate(observed.progress.last(), &observed.truth);
        let mut figures = screw_figures(observed, screwing.tightness);
        figures.push(Figure::duration(observed));
        Evaluation {
            figures,
            cause: None,
            as_expected: screwing.failure.is_none(),
            outcome: screwing.failure.unwrap_or_else(|| "tight".to_owned()),
            expected: "tight",
        }
    }
}

pub(crate) fn angle_text(truth: &WorldTruth) -> String {
    let angle_deg = truth.objects[0].cap_angle_rad.to_degrees();
    format!("turned {}°", atas_console::number(angle_deg, 0))
}

pub(crate) fn screw_figures(seen: &ObservedRun, tightness: f64) -> Vec<Figure> {
    let cap = &seen.truth.objects[0];
    let friction_mn_m = cap.cap_friction_n_m * 1e3;
    vec![
        Figure::count("turns", "turns", seen.turns),
        Figure::new("turned °", "turned_deg", cap.cap_angle_rad.to_degrees(), 0),
        Figure::new(
            "closes at °",
            "closes_at_deg",
            cap.cap_closing_rad.to_degrees(),
            0,
        ),
        Figure::new("thread mN·m", "thread_mn_m", friction_mn_m, 1),
        Figure::new("tight × thread", "tight_over_thread", tightness, 2),
    ]
}
