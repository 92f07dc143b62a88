//! Pick-and-place demo: within 5 mm of the target, released while standing; an object that is too
//! heavy is put back.

use atas_client::goal::LIFT_M;
use atas_console::arguments::Running;
use atas_evaluation::Task;
use atas_evaluation::judge::{Outcome, Placing};
use shm_schemas::{GoalRequest, WorldTruth};
use sim_backend::Object;

use super::Setting;
use super::grasp::{gripped, refused_for};
use super::scenario::{Figure, Judged, Scenario};
use super::seen::Seen;

pub(super) struct PickPlace {
    argument: String,
    set: Setting,
}

impl PickPlace {
    pub(super) fn new(argument: &str, running: &Running) -> anyhow::Result<Self> {
        Ok(Self {
            argument: argument.to_owned(),
            set: Setting::of(Task::PickPlace, running, super::object(argument)?)?,
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

    fn setting(&self) -> Vec<String> {
        ["--scene", "pick-place", "--object", &self.argument]
            .map(str::to_owned)
            .to_vec()
    }

    fn goal(&self) -> GoalRequest {
        self.set.goal
    }

    fn live(&self, truth: &WorldTruth) -> String {
        super::lifted(truth)
    }

    fn judge(&self, seen: &Seen) -> Judged {
        let [x_m, y_m, _] = self.set.goal.to_m;
        let end = seen.progress.last();
        let placing = Placing::of(end, &seen.truth, [x_m, y_m], seen.progress.let_go_ns());
        let feasible = self.set.load().is_feasible();
        let outcome = Outcome::of(end, &seen.truth, self.set.hand(), LIFT_M);
        let refused = !feasible && outcome.is_expected(feasible);
        let mut figures = gripped(seen.progress.figures(), self.set.fingers);
        figures.extend([
            Figure::new("off mm", "off_mm", placing.off_m * 1e3, 1),
            Figure::new(
                "released after ms",
                "released_after_ms",
                placing.latency_s * 1e3,
                1,
            ),
            Figure::new(
                "fingers off ms",
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
            Figure::took(seen),
        ]);
        let word = match &placing.failure {
            Some(_) if refused => "refused".to_owned(),
            Some(failure) => failure.clone(),
            None => "placed".to_owned(),
        };
        Judged {
            figures,
            outcome: word,
            cause: refused_for(outcome).filter(|_| refused),
            should: if feasible { "placed" } else { "refused" },
            as_expected: refused || (feasible && placing.failure.is_none()),
        }
    }
}
