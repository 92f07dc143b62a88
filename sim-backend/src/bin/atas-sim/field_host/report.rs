//! Results of the trials on standard output.

use sim_backend::swarm::TrialReport;

use crate::failure::Failure;
use crate::output::{Format, print};

pub(super) struct Reporter {
    format: Format,
    trials: usize,
    fitness: f32,
    solved: usize,
    missed_frames: u32,
}

impl Reporter {
    pub(super) fn new(format: Format) -> Self {
        Self {
            format,
            trials: 0,
            fitness: 0.0,
            solved: 0,
            missed_frames: 0,
        }
    }

    pub(super) fn record(&mut self, ended: Option<TrialReport>) -> Result<(), Failure> {
        let Some(report) = ended else {
            return Ok(());
        };
        let line = match self.format {
            // Serialisation cannot fail: only numbers and strings.
            Format::Json => serde_json::to_string(&report).unwrap_or_default(),
            Format::Human if self.trials == 0 => format!("{HEADER}\n{}", table_row(&report)),
            Format::Human => table_row(&report),
        };
        print(&[line])?;
        self.trials += 1;
        self.fitness += report.points[0];
        self.solved += usize::from(field::solved(report.points[0]));
        self.missed_frames += report.missed_frames + report.refused_frames;
        Ok(())
    }

    /// Prints the totals and logs them for programs.
    pub(super) fn print_totals(&self, late_periods: u64) -> Result<(), Failure> {
        let Self {
            trials,
            fitness,
            solved,
            missed_frames,
            ..
        } = self;
        if self.format == Format::Human && *trials > 0 {
            print(&[format!(
                "fitness {fitness:.1} of {}, {solved} of {trials} goals solved, {missed_frames} frames without an answer",
                100 * trials
            )])?;
        }
        tracing::info!(trials, missed_frames, late_periods, "field ended");
        Ok(())
    }
}

const HEADER: &str = "goal  distance px  reached at frame  points  missed frames  fields solved";

/// Results of field 0, and the number of solved fields.
fn table_row(report: &TrialReport) -> String {
    let outcome = &report.outcomes[0];
    let reached = match outcome.reached_frame {
        0 => "never".to_owned(),
        frame => frame.to_string(),
    };
    format!(
        "{:>4}  {:>11.1}  {reached:>16}  {:>6.1}  {:>13}  {:>6} of {:>3}",
        report.goal,
        outcome.evaluated.goal_px,
        report.points[0],
        report.missed_frames + report.refused_frames,
        report.solved(),
        report.points.len()
    )
}
