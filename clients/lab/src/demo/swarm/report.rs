//! Results per goal, compared with those of the same table during evolution.

use std::path::Path;

use atas_console::{Exit, ExitError, Output, number, table};
use ebts::table_file::TableFile;
use serde_json::{Value, json};
use sim_backend::swarm::TrialReport;

pub(super) struct Report<'a> {
    pub(super) table: &'a str,
    pub(super) file: &'a TableFile,
    pub(super) trials: &'a [TrialReport],
    pub(super) replay: Option<&'a Path>,
}

impl Report<'_> {
    pub(super) fn print(&self, output: &mut Output) -> anyhow::Result<()> {
        if output.is_json() {
            return output.json(&self.value());
        }
        let mut rows = table(&[
            "goal",
            "distance px",
            "reached at frame",
            "points",
            "points in evolution",
            "outcome",
        ]);
        for (trial, evolved) in self.trials.iter().zip(self.file.points_on_field()) {
            let outcome = &trial.outcomes[0];
            let mut cells: Vec<comfy_table::Cell> = vec![
                trial.goal.into(),
                number(outcome.evaluated.goal_px.into(), 1).into(),
                reached(outcome.reached_frame).into(),
                number(trial.points[0].into(), 1).into(),
                number(evolved.into(), 1).into(),
            ];
            let carried = trial.solved() == 1;
            cells.push(output.rated_cell(
                if carried { "carried" } else { "not carried" },
                carried.into(),
            ));
            rows.add_row(cells);
        }
        output.table(rows)?;
        output.line(self.summary())?;
        if let Some(path) = self.replay {
            output.line(format!("animation: {}", path.display()))?;
        }
        Ok(())
    }

    fn summary(&self) -> String {
        let solved: usize = self.trials.iter().map(TrialReport::solved).sum();
        let team = self.file.condition.team.get();
        let plural = if team == 1 { "" } else { "s" };
        let preset = &self.file.condition.model.preset().name;
        let mut text = format!(
            "{team} robot{plural} on field {preset}: fitness {:.1} of 800, {solved} of 8 goals; table {} {:.16}",
            self.fitness(),
            self.table,
            self.file.hash(),
        );
        text += &match (self.missed_frames(), self.is_as_evolved()) {
            (0, true) => ". Identical to evolution, bit for bit.".to_owned(),
            (missed, _) => format!(
                ". {missed} frames were not answered, and the robots stopped in them: the machine \
                 was overloaded. End other programs, or use --lockstep."
            ),
        };
        text
    }

    /// Returns an error if no frame was missed and the points still differ from evolution.
    pub(super) fn verdict(&self) -> anyhow::Result<()> {
        if self.missed_frames() > 0 || self.is_as_evolved() {
            return Ok(());
        }
        let sentence = "the points of the goals differ from those in the table file; inspect it \
            with `ebts show`";
        Err(ExitError::with_code(Exit::Unexpected, sentence))
    }

    fn is_as_evolved(&self) -> bool {
        let points = self.trials.iter().map(|trial| trial.points[0]);
        points.eq(self.file.points_on_field())
    }

    fn fitness(&self) -> f32 {
        self.trials
            .iter()
            .fold(0.0, |sum, trial| sum + trial.points[0])
    }

    fn missed_frames(&self) -> u32 {
        let missed = |trial: &TrialReport| trial.missed_frames + trial.refused_frames;
        self.trials.iter().map(missed).sum()
    }

    fn value(&self) -> Value {
        let goal = |trial: &TrialReport| {
            let outcome = &trial.outcomes[0];
            json!({
                "goal": trial.goal,
                "distance_px": outcome.evaluated.goal_px,
                "reached_frame": (outcome.reached_frame > 0).then_some(outcome.reached_frame),
                "points": trial.points[0],
                "carried": trial.solved() == 1,
            })
        };
        json!({
            "task": "swarm",
            "table": self.table,
            "hash": self.file.hash(),
            "preset": self.file.condition.model.preset().name,
            "agents": self.file.condition.team.get(),
            "fitness": self.fitness(),
            "evolved_fitness": self.file.individual.fitness(),
            "as_evolved": self.is_as_evolved(),
            "missed_frames": self.missed_frames(),
            "goals": self.trials.iter().map(goal).collect::<Vec<Value>>(),
            "replay": self.replay,
        })
    }
}

fn reached(frame: u32) -> String {
    match frame {
        0 => "never".into(),
        _ => frame.to_string(),
    }
}
