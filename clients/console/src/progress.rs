//! Live progress of a goal on standard error: one updated line on a terminal, otherwise one line
//! per step.

use std::io::{IsTerminal, Write};
use std::time::Duration;

use atas_client::GoalProgress;
use indicatif::{ProgressBar, ProgressStyle};
use shm_schemas::{GoalState, GraspFigures, Status};

use crate::output::{modules, number};

/// Shortest time between two updates of the terminal line (design choice).
const REDRAW: Duration = Duration::from_millis(100);

/// Progress of one goal.
pub struct Progress {
    label: String,
    bar: Option<ProgressBar>,
    last_key: String,
}

impl Progress {
    /// Creates a progress display with a label.
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
            last_key: String::new(),
        }
    }

    /// Prints a line that stays on the screen.
    pub fn print(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.println(text),
            // Failed progress output must not stop the command.
            None => {
                let _ = writeln!(std::io::stderr(), "{}: {text}", self.label);
            }
        }
    }

    /// Shows the current activity before the first update.
    pub fn show_activity(&mut self, text: &str) {
        match &self.bar {
            Some(bar) => bar.set_message(text.to_owned()),
            None => self.print_once(text, text),
        }
    }

    /// Shows a value that changes too often for line output; terminal only.
    pub fn show_live(&self, text: &str) {
        if let Some(bar) = &self.bar {
            bar.set_message(text.to_owned());
        }
    }

    /// Shows the state of a goal of a hand with `fingers` fingertips. `status` adds the active
    /// modules, `live` further values.
    pub fn show_goal(
        &mut self,
        goal: &GoalProgress,
        fingers: usize,
        status: Option<&Status>,
        live: &str,
    ) {
        let last = goal.last();
        let step = last.step.as_str();
        // A rejected goal has no step.
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
            None => self.print_once(step, &line),
        }
    }

    /// Prints `line` if `key` differs from the last printed key.
    fn print_once(&mut self, key: &str, line: &str) {
        if self.last_key != key {
            self.last_key = key.to_owned();
            // Failed progress output must not stop the command.
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

/// Formats F_n of each fingertip, and the thresholds F_1 and F_2.
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
    fn force_is_shown_per_fingertip() {
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
