//! Assembly demo: one hand holds the bottle, the other screws the cap tight; the bottle remains
//! upright.

use atas_console::arguments::Running;
use atas_evaluation::Task;
use atas_evaluation::judge;
use shm_schemas::{GoalRequest, WorldTruth};

use super::Setting;
use super::scenario::{Figure, Judged, Scenario};
use super::screw::{turned, turning};
use super::seen::Seen;

pub(super) struct Assembly {
    argument: String,
    set: Setting,
}

impl Assembly {
    pub(super) fn new(argument: &str, running: &Running) -> anyhow::Result<Self> {
        Ok(Self {
            argument: argument.to_owned(),
            set: Setting::of(Task::Assembly, running, super::cap(argument)?)?,
        })
    }
}

impl Scenario for Assembly {
    fn name(&self) -> &str {
        &self.set.object().name
    }

    fn setting(&self) -> Vec<String> {
        ["--scene", "assembly", "--cap", &self.argument]
            .map(str::to_owned)
            .to_vec()
    }

    fn goal(&self) -> GoalRequest {
        self.set.goal
    }

    fn live(&self, truth: &WorldTruth) -> String {
        format!("{}, {}", super::lifted(truth), turned(truth))
    }

    fn judge(&self, seen: &Seen) -> Judged {
        let assembly = judge::Assembly::of(seen.progress.last(), &seen.start, &seen.truth);
        let mut figures = turning(seen, assembly.tightness);
        let [cap, bottle, ..] = &seen.truth.objects;
        figures.push(Figure::new(
            "tilt °",
            "bottle_tilt_deg",
            assembly.tilt_rad.to_degrees(),
            2,
        ));
        figures.push(Figure::took(seen));
        figures.push(Figure::hidden("cap_closed", cap.cap_closed != 0));
        figures.push(Figure::hidden(
            "bottle_stands",
            bottle.table_n > 0.0 && bottle.tipped == 0,
        ));
        Judged {
            figures,
            cause: None,
            as_expected: assembly.failure.is_none(),
            outcome: assembly
                .failure
                .unwrap_or_else(|| "closed, standing".to_owned()),
            should: "closed, standing",
        }
    }
}
