//! What is known of a goal that was really pursued: its events, and where it was recorded what every tick felt.

use std::ops::Range;
use std::path::PathBuf;

use anyhow::Context;
use atas_client::account::{self, Account, Moment};
use atas_client::words;
use atas_recording::Rows;
use robot_model::Side;
use shm_schemas::{EventKind, HandReport, ModuleEvent, ModuleId, TickReport};

use super::phases::Step;

/// The last goal of a run.
#[derive(Debug)]
pub struct Course {
    /// What the run is called in a legend.
    pub name: String,
    /// How it went.
    pub account: Account,
    events: Vec<ModuleEvent>,
    /// Reports of the goal's ticks, in order; empty where only events are known.
    reports: Vec<TickReport>,
}

impl Course {
    /// From the files of one run, in order.
    ///
    /// # Errors
    /// A file cannot be read to its end, or no goal began in them.
    pub fn recorded(name: &str, files: &[PathBuf]) -> anyhow::Result<Self> {
        let (mut events, mut reports) = (Vec::new(), Vec::new());
        let mut pursued = false;
        for row in Rows::open(files)? {
            let mut row = row?;
            for event in row.events.iter().filter(|e| e.kind == EventKind::GOAL) {
                let begins = account::begins(event);
                if begins {
                    reports.clear();
                }
                pursued = begins;
            }
            let ends = row.events.iter().any(|e| e.kind == EventKind::GOAL) && !pursued;
            events.append(&mut row.events);
            if pursued || ends {
                reports.extend(row.report.map(|report| *report));
            }
        }
        Self::of(name, &events, reports)
    }

    /// From events alone, oldest first, as a running daemon remembers them.
    ///
    /// # Errors
    /// No goal began in them.
    pub fn remembered(name: &str, events: &[ModuleEvent]) -> anyhow::Result<Self> {
        Self::of(name, events, Vec::new())
    }

    fn of(name: &str, events: &[ModuleEvent], reports: Vec<TickReport>) -> anyhow::Result<Self> {
        let events = account::last_goal(events).to_vec();
        let account = account::tell(&events).with_context(|| {
            format!("could not find a goal in {name}: none began in what is known")
        })?;
        Ok(Self {
            name: name.to_owned(),
            account,
            events,
            reports,
        })
    }

    /// A moment in words: what happened, how often, and what the hand felt.
    #[must_use]
    pub fn sentence(&self, moment: &Moment) -> String {
        let often = match moment.times {
            1 => String::new(),
            times => format!(", {times} times in this step"),
        };
        let felt = self.felt(&moment.event);
        let felt = felt.map_or(String::new(), |felt| format!(" ({felt})"));
        format!("{}{often}{felt}", moment.sentence)
    }

    /// What the hand felt in the tick in which a module was switched on, in words; `None` for other events, or where ticks are
    /// not known.
    #[must_use]
    pub fn felt(&self, event: &ModuleEvent) -> Option<String> {
        let hand = event
            .hand
            .index()
            .filter(|_| event.kind == EventKind::MODULE_ON)?;
        let at = self.reports.binary_search_by_key(&event.tick, |r| r.tick);
        Some(words::evidence(
            event.module,
            &self.reports[at.ok()?].hands[hand],
        ))
    }

    /// Whether it is known what the ticks felt.
    pub(super) fn has_ticks(&self) -> bool {
        !self.reports.is_empty()
    }

    /// How long the goal took, s.
    #[must_use]
    pub fn took_s(&self) -> f64 {
        self.since_s(self.account.span_ns[1])
    }

    /// Since the goal began, s.
    #[must_use]
    pub fn since_s(&self, captured_ns: u64) -> f64 {
        captured_ns.saturating_sub(self.account.span_ns[0]) as f64 * 1e-9
    }

    /// The steps of a hand, s since the goal began.
    pub(super) fn steps(&self, side: Side) -> Vec<Step> {
        let own = |step: &&account::Step| step.hand.index() == Some(side.index());
        let steps = self.account.steps.iter().filter(own).map(|step| {
            let from_s = self.since_s(step.captured_ns);
            (
                step.name.clone(),
                from_s..from_s + step.took_ns as f64 * 1e-9,
            )
        });
        steps.collect()
    }

    /// When a step was first entered, s since the goal began.
    pub(super) fn entered_s(&self, step: &str) -> Option<f64> {
        let entered = self.account.steps.iter().find(|s| s.name == step);
        entered.map(|step| self.since_s(step.captured_ns))
    }

    /// A value of a hand over time, s since the goal began; at most `points` of them.
    pub(super) fn series(
        &self,
        side: Side,
        points: usize,
        value: impl Fn(&HandReport) -> f32,
    ) -> Vec<(f64, f64)> {
        let every = self.reports.len().div_ceil(points.max(1)).max(1);
        let values = self.reports.iter().step_by(every).map(|report| {
            let hand = &report.hands[side.index()];
            (
                self.since_s(report.stamp.captured_ns),
                f64::from(value(hand)),
            )
        });
        values.filter(|(_, value)| value.is_finite()).collect()
    }

    /// When a module of a hand worked, s since the goal began.
    pub(super) fn spans(&self, side: Side, module: ModuleId) -> Vec<Range<f64>> {
        let own = |event: &&ModuleEvent| {
            event.module == module && event.hand.index() == Some(side.index())
        };
        let mut spans: Vec<Range<f64>> = Vec::new();
        let mut is_on = false;
        for event in self.events.iter().filter(own) {
            let at_s = self.since_s(event.stamp.captured_ns);
            match event.kind {
                EventKind::MODULE_ON if !is_on => spans.push(at_s..self.took_s()),
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
