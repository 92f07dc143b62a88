//! Goals of a run, and selection of one of them.

use std::path::PathBuf;

use atas_client::goal_summary::{self, GoalSummary};
use atas_recording::{Rows, origin};
use shm_schemas::capacity::HANDS;
use shm_schemas::{Hand, ModuleEvent, Status};

/// Selection of a goal.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum GoalSelection {
    /// Last task; a goal that only releases counts if there is no other.
    #[default]
    LastTask,
    /// Number: 1 is the first, −1 the last.
    Number(i64),
    /// Last goal of this task.
    Task(String),
}

impl GoalSelection {
    /// Parses user input: a number or a task name; `None` selects the last task.
    #[must_use]
    pub fn parse(text: Option<&str>) -> Self {
        match text {
            None => Self::LastTask,
            Some(text) => text
                .parse()
                .map_or_else(|_| Self::Task(text.to_owned()), Self::Number),
        }
    }
}

/// Goals of a run.
#[derive(Debug)]
pub struct Goals {
    run: String,
    events: Vec<ModuleEvent>,
    /// Start time (ns) and task name from status messages.
    status_goals: Vec<(u64, String)>,
    /// Start of the run, ns.
    begun_ns: u64,
    pub(super) fingers: [usize; HANDS],
}

/// Goal of a run.
#[derive(Clone, Debug)]
pub struct Goal<'a> {
    /// Number of the goal, from 1.
    pub number: usize,
    /// Task name; `None` without a matching status message.
    pub task: Option<&'a str>,
    /// Acting hand.
    pub hand: Hand,
    /// Start since the run began, s.
    pub from_s: f64,
    /// Summary of the goal.
    pub summary: GoalSummary,
    pub(super) events: &'a [ModuleEvent],
}

impl Goals {
    /// Reads the files of one run, in order.
    ///
    /// # Errors
    /// A file cannot be read completely.
    pub fn from_recording(run: &str, files: &[PathBuf]) -> anyhow::Result<Self> {
        let mut rows = Rows::open(files)?;
        let mut goals = Self {
            run: run.to_owned(),
            events: Vec::new(),
            status_goals: Vec::new(),
            begun_ns: 0,
            fingers: origin::fingers(rows.header()),
        };
        for row in rows.by_ref() {
            let mut row = row?;
            if goals.begun_ns == 0 {
                goals.begun_ns = row.captured_ns;
            }
            goals.events.append(&mut row.events);
        }
        let reported = rows.goal_statuses().iter();
        goals.status_goals = reported.map(|s| (s.stamp.captured_ns, task(s))).collect();
        Ok(goals)
    }

    /// Builds the list from a running daemon's events, oldest first; its status names the last
    /// task.
    #[must_use]
    pub fn from_events(run: &str, events: Vec<ModuleEvent>, status: &Status) -> Self {
        let last = goal_summary::goals(&events)
            .last()
            .map(|goal| goal[0].stamp);
        let last = last.filter(|_| status.goal_id != 0);
        let reported = last.map(|begun| (begun.captured_ns, task(status)));
        Self {
            run: run.to_owned(),
            status_goals: reported.into_iter().collect(),
            events,
            begun_ns: status.started_ns,
            fingers: origin::fingers(None),
        }
    }

    /// Returns all goals, oldest first.
    #[must_use]
    pub fn list(&self) -> Vec<Goal<'_>> {
        let goals = goal_summary::goals(&self.events).into_iter().enumerate();
        let mut ended_ns = 0;
        goals
            .filter_map(|(index, events)| {
                let runs = events.iter().find(|event| goal_summary::begins(event))?;
                let account = goal_summary::summarise(events)?;
                // Newest status since the previous goal; a goal rejected in between never ran.
                let since_ns = std::mem::replace(&mut ended_ns, account.span_ns[1]);
                let reported = self.status_goals.iter().rev();
                let mut reported = reported.filter(|(ns, _)| (since_ns..=ended_ns).contains(ns));
                Some(Goal {
                    number: index + 1,
                    task: reported.next().map(|(_, task)| task.as_str()),
                    hand: runs.hand,
                    from_s: account.span_ns[0].saturating_sub(self.begun_ns) as f64 * 1e-9,
                    summary: account,
                    events,
                })
            })
            .collect()
    }

    /// Returns the selected goal.
    ///
    /// # Errors
    /// No goal matches.
    pub fn select(&self, choice: &GoalSelection) -> anyhow::Result<Goal<'_>> {
        let mut goals = self.list();
        let (run, count) = (&self.run, goals.len());
        anyhow::ensure!(count > 0, "could not find a goal in {run}: no goal began");
        let index = match choice {
            GoalSelection::LastTask => {
                let is_task = |goal: &Goal<'_>| !goal_summary::is_release(goal.events);
                goals.iter().rposition(is_task).unwrap_or(count - 1)
            }
            GoalSelection::Number(number) => index_of(*number, count).ok_or_else(|| {
                anyhow::anyhow!(
                    "could not find goal {number} of {run}: it has {count} goals; use 1 to \
                     {count}, or -1 to -{count} from the end (`atas explain FILE --list` shows \
                     them)"
                )
            })?,
            GoalSelection::Task(name) => goals
                .iter()
                .rposition(|goal| goal.task == Some(name))
                .ok_or_else(|| {
                    let known: Vec<&str> = goals.iter().filter_map(|goal| goal.task).collect();
                    let known = match &known[..] {
                        [] => "whose task names are unknown; give a number".to_owned(),
                        known => format!("which has {}", known.join(", ")),
                    };
                    anyhow::anyhow!(
                        "could not find a goal of the task {name:?} in {run}, {known} (`atas \
                         explain FILE --list` shows them)"
                    )
                })?,
        };
        Ok(goals.swap_remove(index))
    }
}

fn index_of(number: i64, count: usize) -> Option<usize> {
    let from_end = number < 0;
    let steps = usize::try_from(number.unsigned_abs()).ok()?;
    let is_there = (1..=count).contains(&steps);
    is_there.then(|| if from_end { count - steps } else { steps - 1 })
}

fn task(status: &Status) -> String {
    match status.task.as_str() {
        "" => status.goal_kind.name().to_owned(),
        own => own.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_schemas::{EventKind, Text};

    fn at(tick: u64, kind: EventKind, text: &str) -> ModuleEvent {
        let mut event = ModuleEvent {
            tick,
            kind,
            hand: Hand::RIGHT,
            text: Text::new(text),
            ..ModuleEvent::default()
        };
        event.stamp.captured_ns = tick * 1_000_000;
        event
    }

    /// Three goals: a grasp with a rejected screwing after it, a placing, a release.
    fn three() -> Goals {
        let goal = |tick: u64, step: &str, state: &str| {
            [
                at(tick, EventKind::STEP, step),
                at(tick + 1, EventKind::GOAL, "running"),
                at(tick + 50, EventKind::GOAL, state),
            ]
        };
        let events = [
            goal(100, "reach", "failed"),
            goal(200, "reach", "succeeded"),
            goal(300, "open", "succeeded"),
        ];
        let reported = [
            (101, "grasp"),
            (180, "screw"),
            (201, "pick-place"),
            (301, "release"),
        ];
        Goals {
            run: "run".into(),
            events: events.concat(),
            status_goals: reported
                .map(|(tick, name)| (tick * 1_000_000, name.into()))
                .to_vec(),
            begun_ns: 0,
            fingers: [2, 2],
        }
    }

    #[test]
    fn goals_are_selected_by_number_or_task() {
        let goals = three();
        let listed: Vec<_> = goals.list().iter().map(|g| (g.number, g.task)).collect();
        let expected = [
            (1, Some("grasp")),
            (2, Some("pick-place")),
            (3, Some("release")),
        ];
        assert_eq!(listed, expected);
        let check = |message: Option<&str>, number| {
            let found = goals.select(&GoalSelection::parse(message)).expect("there");
            assert_eq!(found.number, number, "{message:?}");
        };
        check(None, 2);
        check(Some("1"), 1);
        check(Some("-1"), 3);
        check(Some("-3"), 1);
        check(Some("grasp"), 1);
        check(Some("release"), 3);
        for (message, part) in [
            ("0", "use 1 to 3"),
            ("4", "use 1 to 3"),
            ("-4", "use 1 to 3"),
            ("-9223372036854775808", "use 1 to 3"),
            ("polish", "which has grasp, pick-place, release"),
        ] {
            let error = goals
                .select(&GoalSelection::parse(Some(message)))
                .expect_err(message);
            assert!(error.to_string().contains(part), "{error}");
        }
    }

    #[test]
    fn release_is_recognised_by_its_first_step() {
        for task in atas_core::tasks::BUILT_IN {
            let first = at(1, EventKind::STEP, task.acting[0].name.as_str());
            let only_lets_go = goal_summary::is_release(&[first]);
            assert_eq!(only_lets_go, task.name == "release", "{}", task.name);
        }
    }
}
