//! What became of every goal, on standard output, as soon as it is known.

use sim_backend::swarm::TrialReport;

use crate::failure::Failure;
use crate::output::{Format, print};

/// Prints, and sums up.
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

    /// Prints a trial that has just ended.
    pub(super) fn note(&mut self, ended: Option<TrialReport>) -> Result<(), Failure> {
        let Some(report) = ended else {
            return Ok(());
        };
        let line = match self.format {
            // Numbers and strings always have a JSON form.
            Format::Json => serde_json::to_string(&report).unwrap_or_default(),
            Format::Human if self.trials == 0 => format!("{HEADER}\n{}", sentence(&report)),
            Format::Human => sentence(&report),
        };
        print(&[line])?;
        self.trials += 1;
        self.fitness += report.points[0];
        self.solved += usize::from(field::solved(report.points[0]));
        self.missed_frames += report.missed_frames + report.refused_frames;
        Ok(())
    }

    /// Says what it came to in all; the log has it for programs too.
    pub(super) fn end(&self, late_periods: u64) -> Result<(), Failure> {
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
        tracing::info!(trials, missed_frames, late_periods, "field closed");
        Ok(())
    }
}

const HEADER: &str = "goal  distance px  reached at frame  points  missed frames  fields solved";

/// One line of the table: field 0, and how many of all the fields were solved.
fn sentence(report: &TrialReport) -> String {
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
