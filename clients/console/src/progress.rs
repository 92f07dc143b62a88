//! Live progress of a goal on standard error: one line that changes on a terminal, one line per step elsewhere.

use std::io::{IsTerminal, Write};
use std::time::Duration;

use atas_client::GoalProgress;
use indicatif::{ProgressBar, ProgressStyle};
use shm_schemas::{GoalState, GraspFigures, Status};

use crate::output::{modules, number};

/// How often the terminal's line changes at most (ours).
const REDRAW: Duration = Duration::from_millis(100);

/// Progress of one goal.
pub struct Progress {
    label: String,
    bar: Option<ProgressBar>,
    told: String,
}

impl Progress {
    /// Progress under a label.
    pub fn new(label: &str) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new_spinner().with_style(
                ProgressStyle::with_template("{spinner} {prefix:16} {msg}")
                    .unwrap_or_else(|_| ProgressStyle::default_spinner()),
            );
            bar.set_prefix(label.to_owned());
            bar.enable_steady_tick(REDRAW);
            bar
        });
        Self {
            label: label.to_owned(),
            bar,
            told: String::new(),
        }
    }

    /// Says what must stay on the screen.
    pub fn say(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.println(text),
            // Progress that nobody can read must not end the work.
            None => {
                let _ = writeln!(std::io::stderr(), "{}: {text}", self.label);
            }
        }
    }

    /// Says what is going on before the first update.
    pub fn note(&mut self, text: &str) {
        match &self.bar {
            Some(bar) => bar.set_message(text.to_owned()),
            None => self.tell(text, text),
        }
    }

    /// Shows what changes too often to be told line by line.
    pub fn live(&self, text: &str) {
        if let Some(bar) = &self.bar {
            bar.set_message(text.to_owned());
        }
    }

    /// Shows where the goal of a hand with so many fingers stands. `status` adds the active modules, `live` what else is worth
    /// watching.
    pub fn show(
        &mut self,
        goal: &GoalProgress,
        fingers: usize,
        status: Option<&Status>,
        live: &str,
    ) {
        let last = goal.last();
        let step = last.step.as_str();
        // A goal that was rejected has no step: nothing has begun.
        if step.is_empty() || last.state == GoalState::REJECTED {
            return;
        }
        let mut line = format!("{step:8} {}", forces(&last.figures, fingers));
        if let Some(status) = status {
            let active = status
                .hands
                .iter()
                .fold(0, |bits, hand| bits | hand.modules_active);
            line += &format!("  {}", modules(active));
        }
        line += &format!("  {live}");
        match &self.bar {
            Some(bar) => bar.set_message(line),
            None => self.tell(step, &line),
        }
    }

    /// Prints `line` if `key` is not the one told last.
    fn tell(&mut self, key: &str, line: &str) {
        if self.told != key {
            self.told = key.to_owned();
            // Progress that nobody can read must not end the work.
            let _ = writeln!(std::io::stderr(), "{}: {line}", self.label);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// F_n of each finger between its two thresholds.
fn forces(figures: &GraspFigures, fingers: usize) -> String {
    let pressed = figures.normal_n.iter().take(fingers);
    let pressed: Vec<String> = pressed.map(|n| number((*n).into(), 2)).collect();
    let (pressed, f1_n, f2_n) = (pressed.join(" "), figures.f1_n, figures.f2_n);
    format!("F_n {pressed} N  F_1 {f1_n:.2}  F_2 {f2_n:.2}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_finger_has_its_force() {
        let figures = GraspFigures {
            normal_n: [0.5, 1.25, 2.0, 0.0],
            ..GraspFigures::default()
        };
        assert_eq!(
            forces(&figures, 3),
            "F_n 0.50 1.25 2.00 N  F_1 0.00  F_2 0.00"
        );
    }
}
