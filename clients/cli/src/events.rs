//! `atas events`: prints the events of the daemon.

use std::time::{Duration, Instant};

use atas_client::{POLL, Session, json, text};
use atas_console::arguments::Events;
use atas_console::{Interrupt, Output};
use serde_json::Value;
use shm_schemas::{EventKind, GoalState, Hand, ModuleEvent, Status, StatusFlags, service};

const BATCH: usize = 256;
/// Longest wait for past events. The daemon sends them to a new reader with its next message.
/// Design choice.
const HISTORY_WAIT: Duration = Duration::from_millis(300);

pub(crate) fn events(
    arguments: &Events,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let session = Session::existing(&arguments.bus.bus)?;
    let mut stream = session
        .bus()
        .subscriber::<ModuleEvent>(service::MODULE_EVENT)?;
    let (mut statuses, mut status) = session.watch_status()?;
    let mut teller = Printer::new(&status);
    let mut filter = Filter::new(arguments);
    let waits = arguments.follow || arguments.count.is_some();
    let begin = Instant::now();
    let mut left = arguments.count.unwrap_or(u64::MAX);
    while left > 0 && !interrupt.is_set() && (waits || begin.elapsed() < HISTORY_WAIT) {
        if statuses.newest(&mut status)? {
            teller.started_ns = status.started_ns;
        }
        if arguments.follow {
            teller.print_conditions(&status, output)?;
        }
        let mut batch = Vec::new();
        let most = usize::try_from(left).unwrap_or(BATCH).min(BATCH);
        stream.drain(most, |event| batch.push(*event))?;
        for event in &batch {
            let lost = teller.lost_before(event);
            if let Some(event) = filter.apply(event)
                && left > 0
            {
                teller.print(&event, lost, output)?;
                left -= 1;
            }
        }
        if batch.is_empty() {
            std::thread::sleep(POLL);
        }
    }
    for event in filter.last_goal_events() {
        teller.print(&event, 0, output)?;
    }
    Ok(())
}

/// Selection of the events to print.
struct Filter {
    kinds: Vec<EventKind>,
    hand: Option<Hand>,
    /// Events of the last goal so far; `None` without `--last-goal`.
    last_goal: Option<Vec<ModuleEvent>>,
}

impl Filter {
    fn new(arguments: &Events) -> Self {
        Self {
            kinds: arguments.kinds.clone(),
            hand: arguments.hand.map(Hand::from),
            last_goal: arguments.last_goal.then(Vec::new),
        }
    }

    /// Returns the event if it is to be printed now.
    fn apply(&mut self, event: &ModuleEvent) -> Option<ModuleEvent> {
        let begins =
            event.kind == EventKind::GOAL && event.text.as_str() == GoalState::RUNNING.name();
        if let Some(goal) = &mut self.last_goal
            && begins
        {
            goal.clear();
        }
        // A mode applies to the whole robot.
        let is_of = |hand: Hand| event.hand == hand || event.kind == EventKind::MODE;
        let wanted = (self.kinds.is_empty() || self.kinds.contains(&event.kind))
            && self.hand.is_none_or(is_of);
        match (&mut self.last_goal, wanted) {
            (_, false) => None,
            (None, true) => Some(*event),
            (Some(goal), true) => {
                goal.push(*event);
                None
            }
        }
    }

    fn last_goal_events(self) -> Vec<ModuleEvent> {
        self.last_goal.unwrap_or_default()
    }
}

/// Prints events and the number of lost events between them.
struct Printer {
    /// Start of the daemon; in lock-step known after the first tick.
    started_ns: u64,
    expected: Option<(u64, u64)>,
    conditions: Option<u32>,
}

/// Status flags that affect the reliability of tick times: flag, text if set, text if clear.
const CONDITIONS: [(u32, &str, &str); 3] = [
    (
        StatusFlags::PHASE_LOCKED,
        "phase-locked",
        "not phase-locked",
    ),
    (
        StatusFlags::REALTIME,
        "real-time scheduling",
        "ordinary scheduling",
    ),
    (StatusFlags::DEGRADED, "DEGRADED", "not degraded"),
];

impl Printer {
    fn new(status: &Status) -> Self {
        Self {
            started_ns: status.started_ns,
            expected: None,
            conditions: None,
        }
    }

    fn print(&mut self, event: &ModuleEvent, lost: u64, output: &mut Output) -> anyhow::Result<()> {
        if output.is_json() {
            let mut value = json::event(event);
            value["lost_before"] = Value::from(lost);
            return output.json(&value);
        }
        if lost > 0 {
            output.line(format!("           ({lost} events lost)"))?;
        }
        let since_start_s = self.since_start_s(event.stamp.captured_ns);
        output.line(format!("{since_start_s:10.3} s  {}", text::event(event)))
    }

    /// Prints the tick conditions at the start and on each change. They are states, not events:
    /// they have no sequence number and do not count.
    fn print_conditions(&mut self, status: &Status, output: &mut Output) -> anyhow::Result<()> {
        let flags = CONDITIONS
            .iter()
            .fold(0, |flags, (flag, ..)| flags | status.flags & flag);
        if self.conditions.replace(flags) == Some(flags) {
            return Ok(());
        }
        if output.is_json() {
            return output.json(&json::conditions(status));
        }
        let words = CONDITIONS.map(|(flag, on, off)| if flags & flag != 0 { on } else { off });
        let at_s = self.since_start_s(status.stamp.captured_ns);
        output.line(format!("{at_s:10.3} s         ticks: {}", words.join(", ")))
    }

    fn since_start_s(&self, captured_ns: u64) -> f64 {
        captured_ns.saturating_sub(self.started_ns) as f64 * 1e-9
    }

    /// Returns the number of lost events of the same writer before this one.
    fn lost_before(&mut self, event: &ModuleEvent) -> u64 {
        let (epoch, sequence) = (event.stamp.writer_epoch, event.stamp.sequence);
        let lost = match self.expected {
            Some((same, next)) if same == epoch => sequence.saturating_sub(next),
            _ => 0,
        };
        self.expected = Some((epoch, sequence.wrapping_add(1)));
        lost
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_schemas::{Stamp, Text};

    fn right(kind: EventKind) -> ModuleEvent {
        ModuleEvent {
            kind,
            hand: Hand::RIGHT,
            ..ModuleEvent::default()
        }
    }

    #[test]
    fn filter_passes_only_selected_events() {
        let goal = |state: GoalState| ModuleEvent {
            text: Text::new(state.name()),
            ..right(EventKind::GOAL)
        };
        let stream = [
            goal(GoalState::RUNNING),
            right(EventKind::STEP),
            goal(GoalState::FAILED),
            goal(GoalState::RUNNING),
            right(EventKind::TOUCH_ON),
            right(EventKind::STEP),
        ];
        let check = |kinds: &[EventKind], hand, last_goal: bool, expected: &[EventKind]| {
            let mut filter = Filter {
                kinds: kinds.to_vec(),
                hand,
                last_goal: last_goal.then(Vec::new),
            };
            let mut reported: Vec<ModuleEvent> = stream
                .iter()
                .filter_map(|event| filter.apply(event))
                .collect();
            reported.extend(filter.last_goal_events());
            let kinds: Vec<EventKind> = reported.iter().map(|event| event.kind).collect();
            assert_eq!(kinds, expected);
        };
        use EventKind as K;
        check(&[], None, false, &stream.map(|event| event.kind));
        check(&[K::STEP], None, false, &[K::STEP; 2]);
        check(&[], Some(Hand::LEFT), false, &[]);
        check(&[], None, true, &[K::GOAL, K::TOUCH_ON, K::STEP]);
        check(&[K::TOUCH_ON], Some(Hand::RIGHT), true, &[K::TOUCH_ON]);
    }

    #[test]
    fn lost_events_are_counted_per_writer() {
        let mut teller = Printer::new(&Status::default());
        let mut check = |writer_epoch, sequence, lost| {
            let stamp = Stamp {
                sequence,
                writer_epoch,
                ..Stamp::default()
            };
            let event = ModuleEvent {
                stamp,
                ..ModuleEvent::default()
            };
            assert_eq!(
                teller.lost_before(&event),
                lost,
                "{writer_epoch} {sequence}"
            );
        };
        check(1, 5, 0);
        check(1, 6, 0);
        check(1, 9, 2);
        check(2, 0, 0);
        check(2, 1, 0);
    }
}
