//! Goal summary: steps and decisive moments of a goal, from its events.

use shm_schemas::{EventKind, GoalState, Hand, ModuleEvent, ModuleId, ReasonRecord};

use crate::text;

/// Modules that react to events; the others execute the plan.
const REACTING: [ModuleId; 8] = [
    ModuleId::SLIP,
    ModuleId::FORCE_LIMIT,
    ModuleId::FIRST_TOUCH,
    ModuleId::CONTACT_GUARD,
    ModuleId::LIFT_VERIFICATION,
    ModuleId::TERMINATE_SCREW,
    ModuleId::RELEASE_PLACED,
    ModuleId::SLIP_REACTION,
];

/// First step of the release task, as in the controller's table (tested).
const OPEN: &str = "open";

/// Summary of one goal.
#[derive(Clone, Debug, PartialEq)]
pub struct GoalSummary {
    /// Final state; the newest one if the goal has not ended.
    pub state: String,
    /// Reason of an end without success.
    pub reason: ReasonRecord,
    /// Time of the first and the last event, ns.
    pub span_ns: [u64; 2],
    /// Steps of the hands, in order.
    pub steps: Vec<Step>,
    /// Decisive moments, in order.
    pub moments: Vec<Moment>,
}

impl GoalSummary {
    /// Returns the time from the first to the last event, s.
    #[must_use]
    pub fn took_s(&self) -> f64 {
        let [first_ns, last_ns] = self.span_ns;
        last_ns.saturating_sub(first_ns) as f64 * 1e-9
    }
}

/// Step of one hand.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Its name.
    pub name: String,
    /// Hand of the step.
    pub hand: Hand,
    /// Time of entry, ns.
    pub captured_ns: u64,
    /// Duration, ns.
    pub took_ns: u64,
}

/// Decisive moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// Event.
    pub event: ModuleEvent,
    /// Text of the event.
    pub text: String,
    /// Number of repetitions within the step.
    pub times: u32,
}

/// Returns true if a goal begins to run with this event.
#[must_use]
pub fn begins(event: &ModuleEvent) -> bool {
    event.kind == EventKind::GOAL && event.text.as_str() == GoalState::RUNNING.name()
}

/// Returns the events of each goal, from its first step to its end, oldest first.
#[must_use]
pub fn goals(events: &[ModuleEvent]) -> Vec<&[ModuleEvent]> {
    let runs = (0..events.len()).filter(|at| begins(&events[*at]));
    runs.map(|runs| goal(events, runs)).collect()
}

/// Returns the events of the goal that runs with the event at this index.
fn goal(events: &[ModuleEvent], runs: usize) -> &[ModuleEvent] {
    // The first step is reported on acceptance: before the goal runs and after the previous goal.
    let before = events[..runs].iter().rev();
    let mut before = before.take_while(|event| event.kind != EventKind::GOAL);
    let first = before.find(|event| event.kind == EventKind::STEP);
    let first = first.unwrap_or(&events[runs]).tick;
    let begin = events.partition_point(|event| event.tick < first);
    let ends = |event: &ModuleEvent| event.kind == EventKind::GOAL;
    let after = &events[runs + 1..];
    // A goal without a recorded end has ended before the next one begins.
    let end = match after.iter().position(ends) {
        Some(end) if begins(&after[end]) => end,
        Some(end) => end + 1,
        None => after.len(),
    };
    &events[begin.min(runs)..runs + 1 + end]
}

/// Returns true if a goal only releases an object: its first step is `open`.
#[must_use]
pub fn is_release(goal: &[ModuleEvent]) -> bool {
    let mut steps = goal.iter().filter(|event| event.kind == EventKind::STEP);
    steps.next().is_some_and(|step| step.text.as_str() == OPEN)
}

/// Summarises a goal from its events, oldest first; `None` without events.
#[must_use]
pub fn summarise(events: &[ModuleEvent]) -> Option<GoalSummary> {
    let (first, last) = (events.first()?, events.last()?);
    let mut goals = events.iter().filter(|event| event.kind == EventKind::GOAL);
    let is_final = |event: &&ModuleEvent| !begins(event);
    let end = goals.clone().rfind(is_final).or_else(|| goals.next_back());
    Some(GoalSummary {
        state: end.map_or("running".to_owned(), |end| end.text.to_string()),
        reason: end.map_or_else(ReasonRecord::default, |end| end.reason),
        span_ns: [first.stamp.captured_ns, last.stamp.captured_ns],
        steps: steps(events, last.stamp.captured_ns),
        moments: moments(events),
    })
}

fn steps(events: &[ModuleEvent], end_ns: u64) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    let close = |steps: &mut Vec<Step>, hand: Hand, at_ns: u64| {
        if let Some(step) = steps.iter_mut().rev().find(|step| step.hand == hand) {
            step.took_ns = at_ns.saturating_sub(step.captured_ns);
        }
    };
    for event in events.iter().filter(|event| event.kind == EventKind::STEP) {
        let captured_ns = event.stamp.captured_ns;
        close(&mut steps, event.hand, captured_ns);
        steps.push(Step {
            name: event.text.to_string(),
            hand: event.hand,
            captured_ns,
            took_ns: 0,
        });
    }
    for hand in Hand::BOTH {
        close(&mut steps, hand, end_ns);
    }
    steps
}

/// Returns touches, stiffness, module reactions, warnings, mode changes and the end. Repetitions
/// within a step are merged and counted.
fn moments(events: &[ModuleEvent]) -> Vec<Moment> {
    let mut moments: Vec<Moment> = Vec::new();
    let mut since_step = 0;
    for event in events {
        if event.kind == EventKind::STEP {
            since_step = moments.len();
        }
        if !decides(event) {
            continue;
        }
        let alike = |moment: &&mut Moment| {
            let (a, b) = (&moment.event, event);
            (a.kind, a.module, a.hand, a.finger) == (b.kind, b.module, b.hand, b.finger)
                && a.kind != EventKind::MODE
                && a.kind != EventKind::GOAL
        };
        match moments[since_step..].iter_mut().find(alike) {
            Some(moment) => moment.times += 1,
            None => moments.push(Moment {
                event: *event,
                text: text::event(event),
                times: 1,
            }),
        }
    }
    moments
}

fn decides(event: &ModuleEvent) -> bool {
    match event.kind {
        EventKind::MODULE_ON => REACTING.contains(&event.module),
        EventKind::MODULE_OFF | EventKind::TOUCH_OFF => false,
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_schemas::{Reason, Stamp, Text};

    fn at(ms: u64, kind: EventKind, text: &str) -> ModuleEvent {
        ModuleEvent {
            stamp: Stamp {
                captured_ns: ms * 1_000_000,
                ..Stamp::default()
            },
            tick: ms,
            kind,
            hand: Hand::RIGHT,
            text: Text::new(text),
            ..ModuleEvent::default()
        }
    }

    #[test]
    fn summary_has_steps_and_decisive_moments() {
        let on = |ms, module| ModuleEvent {
            module,
            ..at(ms, EventKind::MODULE_ON, "")
        };
        let too_heavy = Reason::TooHeavy {
            force_n: 18.4,
            limit_n: 8.0,
            module: ModuleId::FORCE_LIMIT,
        };
        let events = [
            at(1, EventKind::GOAL, "running"),
            at(2, EventKind::GOAL, "failed"),
            at(10, EventKind::GOAL, "running"),
            at(10, EventKind::STEP, "close"),
            on(20, ModuleId::CARRY),
            on(30, ModuleId::SLIP),
            at(40, EventKind::STEP, "lift"),
            on(50, ModuleId::SLIP),
            on(60, ModuleId::SLIP),
            ModuleEvent {
                reason: too_heavy.into(),
                ..at(70, EventKind::GOAL, "failed")
            },
            at(80, EventKind::MODE, ""),
        ];
        let all = goals(&events);
        assert_eq!(
            all.iter().map(|goal| goal.len()).collect::<Vec<_>>(),
            [2, 8]
        );
        let goal = all[1];
        let account = summarise(goal).expect("told");
        assert_eq!(
            (account.state.as_str(), Reason::from(account.reason)),
            ("failed", too_heavy)
        );
        let steps: Vec<_> = account
            .steps
            .iter()
            .map(|s| (s.name.as_str(), s.took_ns / 1_000_000))
            .collect();
        assert_eq!(steps, [("close", 30), ("lift", 30)]);
        let reported: Vec<_> = account
            .moments
            .iter()
            .map(|m| (m.event.tick, m.times))
            .collect();
        // The beginning, its step, the slip in it, the next step, two slips in that, the end.
        assert_eq!(
            reported,
            [(10, 1), (10, 1), (30, 1), (40, 1), (50, 2), (70, 1)]
        );
        assert_eq!((goals(&[]).len(), summarise(&[])), (0, None));
        // The first step is reported on acceptance, a tick before the goal runs.
        let mut accepted = events[..2].to_vec();
        accepted.push(at(9, EventKind::STEP, "reach"));
        accepted.extend(&events[2..]);
        let all = goals(&accepted);
        let account = summarise(all[1]).expect("told");
        assert_eq!(account.steps[0].name, "reach");
        assert_eq!(account.state, "failed");
    }

    #[test]
    fn goal_that_begins_with_open_is_a_release() {
        let events = [
            at(9, EventKind::STEP, "reach"),
            at(10, EventKind::GOAL, "running"),
            at(20, EventKind::STEP, "open"),
            at(30, EventKind::GOAL, "failed"),
            at(39, EventKind::STEP, "open"),
            at(40, EventKind::GOAL, "running"),
            at(50, EventKind::STEP, "leave"),
            // The end was lost.
            at(59, EventKind::STEP, "reach"),
            at(60, EventKind::GOAL, "running"),
        ];
        let reported: Vec<_> = goals(&events)
            .into_iter()
            .map(|goal| (goal[0].tick, is_release(goal)))
            .collect();
        assert_eq!(reported, [(9, false), (39, true), (59, false)]);
    }
}
