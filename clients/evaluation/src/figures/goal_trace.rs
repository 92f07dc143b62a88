//! Data of one goal of a real run: its events, and the report of every tick if recorded.

use std::ops::Range;
use std::path::PathBuf;

use atas_client::goal_summary::{self, GoalSummary, Moment};
use atas_client::text;
use atas_recording::Rows;
use robot_model::HandSide;
use shm_schemas::capacity::{FINGERS, HANDS};
use shm_schemas::{EventKind, FingerReport, HandReport, ModuleEvent, ModuleId, TickReport};

use super::goals::{GoalSelection, Goals};
use super::phases::Step;

/// Goal of a run.
#[derive(Debug)]
pub struct GoalTrace {
    /// Name of the run in a legend.
    pub name: String,
    /// Number of the goal in the run, from 1.
    pub number: usize,
    /// Name of the task, if known.
    pub task: Option<String>,
    /// Summary of the goal.
    pub summary: GoalSummary,
    events: Vec<ModuleEvent>,
    /// Reports of the goal's ticks, if recorded.
    reports: Vec<TickReport>,
    fingers: [usize; HANDS],
}

impl GoalTrace {
    /// Reads a goal from the files of one run, in order.
    ///
    /// # Errors
    /// A file cannot be read completely, or no such goal began in them.
    pub fn from_recording(
        name: &str,
        files: &[PathBuf],
        choice: &GoalSelection,
    ) -> anyhow::Result<Self> {
        let goals = Goals::from_recording(name, files)?;
        let mut course = Self::from_events(name, &goals, choice)?;
        let Some((first, last)) = course.events.first().zip(course.events.last()) else {
            return Ok(course);
        };
        let ticks = first.tick..=last.tick;
        // Second pass, because the choice of the goal needs all events.
        for row in Rows::open(files)? {
            let row = row?;
            if row.tick > *ticks.end() {
                break;
            }
            if ticks.contains(&row.tick) {
                course.reports.extend(row.report.map(|report| *report));
            }
        }
        Ok(course)
    }

    /// Takes a goal from events only.
    ///
    /// # Errors
    /// No such goal began.
    pub fn from_events(name: &str, goals: &Goals, choice: &GoalSelection) -> anyhow::Result<Self> {
        let goal = goals.select(choice)?;
        Ok(Self {
            name: name.to_owned(),
            number: goal.number,
            task: goal.task.map(str::to_owned),
            events: goal.events.to_vec(),
            summary: goal.summary,
            reports: Vec::new(),
            fingers: goals.fingers,
        })
    }

    /// Returns the goal as text, for example `goal 2, grasp`.
    #[must_use]
    pub fn title(&self) -> String {
        let task = self.task.as_ref();
        let task = task.map_or_else(String::new, |task| format!(", {task}"));
        format!("goal {}{task}", self.number)
    }

    pub(super) fn fingers(&self, side: HandSide) -> usize {
        self.fingers[side.index()].clamp(1, FINGERS)
    }

    /// Returns a key event as text: what happened, how often, and the measured values.
    #[must_use]
    pub fn event_text(&self, moment: &Moment) -> String {
        let often = match moment.times {
            1 => String::new(),
            times => format!(", {times} times in this step"),
        };
        let sensed = self.measured(&moment.event);
        let sensed = sensed.map_or(String::new(), |sensed| format!(" ({sensed})"));
        format!("{}{often}{sensed}", moment.text)
    }

    /// Returns the measured values when a module became active; `None` for other events, or without
    /// reports.
    #[must_use]
    pub fn measured(&self, event: &ModuleEvent) -> Option<String> {
        let hand = event
            .hand
            .index()
            .filter(|_| event.kind == EventKind::MODULE_ON)?;
        let at = self.reports.binary_search_by_key(&event.tick, |r| r.tick);
        let report = &self.reports[at.ok()?].hands[hand];
        Some(text::evidence(event.module, report, self.fingers[hand]))
    }

    pub(super) fn has_ticks(&self) -> bool {
        !self.reports.is_empty()
    }

    /// Returns the duration of the goal, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.summary.took_s()
    }

    /// Returns the time since the goal began, s.
    #[must_use]
    pub fn since_s(&self, captured_ns: u64) -> f64 {
        captured_ns.saturating_sub(self.summary.span_ns[0]) as f64 * 1e-9
    }

    pub(super) fn steps(&self, side: HandSide) -> Vec<Step> {
        let own = |step: &&goal_summary::Step| step.hand.index() == Some(side.index());
        let steps = self.summary.steps.iter().filter(own).map(|step| {
            let from_s = self.since_s(step.captured_ns);
            (
                step.name.clone(),
                from_s..from_s + step.took_ns as f64 * 1e-9,
            )
        });
        steps.collect()
    }

    pub(super) fn entered_s(&self, step: &str) -> Option<f64> {
        let entered = self.summary.steps.iter().find(|s| s.name == step);
        entered.map(|step| self.since_s(step.captured_ns))
    }

    /// Returns a value over time, s since the goal began; at most `points` values.
    pub(super) fn series(
        &self,
        side: HandSide,
        points: usize,
        value: impl Fn(&HandReport, &[FingerReport]) -> f32,
    ) -> Vec<(f64, f64)> {
        let fingers = self.fingers(side);
        let every = self.reports.len().div_ceil(points.max(1)).max(1);
        let values = self.reports.iter().step_by(every).map(|report| {
            let hand = &report.hands[side.index()];
            (
                self.since_s(report.stamp.captured_ns),
                f64::from(value(hand, &hand.fingers[..fingers])),
            )
        });
        values.filter(|(_, value)| value.is_finite()).collect()
    }

    pub(super) fn spans(&self, side: HandSide, module: ModuleId) -> Vec<Range<f64>> {
        let own = |event: &&ModuleEvent| {
            event.module == module && event.hand.index() == Some(side.index())
        };
        let mut spans: Vec<Range<f64>> = Vec::new();
        let mut is_on = false;
        for event in self.events.iter().filter(own) {
            let at_s = self.since_s(event.stamp.captured_ns);
            match event.kind {
                EventKind::MODULE_ON if !is_on => spans.push(at_s..self.duration_s()),
                EventKind::MODULE_OFF if is_on => {
                    spans
                        .last_mut()
                        .into_iter()
                        .for_each(|span| span.end = at_s);
                }
                _ => continue,
            }
            is_on = event.kind == EventKind::MODULE_ON;
        }
        spans
    }
}
