//! Why a goal ended as it did: its steps and its decisive moments, out of its events.

use shm_schemas::{EventKind, GoalState, Hand, ModuleEvent, ModuleId, Reason};

use crate::words;

/// Modules that answer something that happens; the others carry out the plan.
const ANSWERING: [ModuleId; 8] = [
    ModuleId::SLIP,
    ModuleId::FORCE_LIMIT,
    ModuleId::FIRST_TOUCH,
    ModuleId::CONTACT_GUARD,
    ModuleId::LOAD_TEST,
    ModuleId::TERMINATE_SCREW,
    ModuleId::RELEASE_PLACED,
    ModuleId::SLIP_REACTION,
];

/// First step of the task that only lets go, as the controller's table names it; a test compares.
const OPEN: &str = "open";

/// One goal, told.
#[derive(Clone, Debug, PartialEq)]
pub struct Account {
    /// State at the end; the newest known if it has not ended.
    pub state: String,
    /// Why, if it did not succeed.
    pub reason: Reason,
    /// Time of the first and the last event, ns.
    pub span_ns: [u64; 2],
    /// What the hands did, in order.
    pub steps: Vec<Step>,
    /// What decided, in order.
    pub moments: Vec<Moment>,
}

impl Account {
    /// From the first to the last event, s.
    #[must_use]
    pub fn took_s(&self) -> f64 {
        let [first_ns, last_ns] = self.span_ns;
        last_ns.saturating_sub(first_ns) as f64 * 1e-9
    }
}

/// A step of one hand.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Its name.
    pub name: String,
    /// Whose.
    pub hand: Hand,
    /// When it was entered, ns.
    pub captured_ns: u64,
    /// How long it lasted, ns.
    pub took_ns: u64,
}

/// Something that decided.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// What happened.
    pub event: ModuleEvent,
    /// In words.
    pub sentence: String,
    /// How often it happened in the same step.
    pub times: u32,
}

/// Whether a goal begins to run with this event.
#[must_use]
pub fn begins(event: &ModuleEvent) -> bool {
    event.kind == EventKind::GOAL && event.text.as_str() == GoalState::RUNNING.name()
}

/// The events of each goal, from its first step to its end, oldest first.
#[must_use]
pub fn goals(events: &[ModuleEvent]) -> Vec<&[ModuleEvent]> {
    let runs = (0..events.len()).filter(|at| begins(&events[*at]));
    runs.map(|runs| goal(events, runs)).collect()
}

/// The events of the goal that runs with the event at this place.
fn goal(events: &[ModuleEvent], runs: usize) -> &[ModuleEvent] {
    // Its first step is announced when it is accepted: before it runs, and after any goal before it.
    let before = events[..runs].iter().rev();
    let mut before = before.take_while(|event| event.kind != EventKind::GOAL);
    let first = before.find(|event| event.kind == EventKind::STEP);
    let first = first.unwrap_or(&events[runs]).tick;
    let begin = events.partition_point(|event| event.tick < first);
    let ends = |event: &ModuleEvent| event.kind == EventKind::GOAL;
    let after = &events[runs + 1..];
    // One whose end nobody heard has ended before the next begins.
    let end = match after.iter().position(ends) {
        Some(end) if begins(&after[end]) => end,
        Some(end) => end + 1,
        None => after.len(),
    };
    &events[begin.min(runs)..runs + 1 + end]
}

/// Whether a goal only lets go of what was held, by its events: it begins by opening.
#[must_use]
pub fn only_lets_go(goal: &[ModuleEvent]) -> bool {
    let mut steps = goal.iter().filter(|event| event.kind == EventKind::STEP);
    steps.next().is_some_and(|step| step.text.as_str() == OPEN)
}

/// Tells a goal by its events, oldest first; `None` if there are none.
#[must_use]
pub fn tell(events: &[ModuleEvent]) -> Option<Account> {
    let (first, last) = (events.first()?, events.last()?);
    let mut goals = events.iter().filter(|event| event.kind == EventKind::GOAL);
    let is_final = |event: &&ModuleEvent| !begins(event);
    let end = goals.clone().rfind(is_final).or_else(|| goals.next_back());
    Some(Account {
        state: end.map_or("running".to_owned(), |end| end.text.to_string()),
        reason: end.map_or(Reason::default(), |end| end.reason),
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

/// Touches, the stiffness, what modules answered, warnings, changes of the mode, the end. What repeats within a step is
/// told once, with how often.
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
                sentence: words::event(event),
                times: 1,
            }),
        }
    }
    moments
}

fn decides(event: &ModuleEvent) -> bool {
    match event.kind {
        EventKind::MODULE_ON => ANSWERING.contains(&event.module),
        EventKind::MODULE_OFF | EventKind::TOUCH_OFF => false,
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_schemas::{Cause, Stamp, Text};

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
    fn a_goal_is_told_by_its_steps_and_what_decided() {
        let on = |ms, module| ModuleEvent {
            module,
            ..at(ms, EventKind::MODULE_ON, "")
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
                reason: Reason::limit(Cause::TOO_HEAVY, 18.4, 8.0),
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
        let account = tell(goal).expect("told");
        assert_eq!(
            (account.state.as_str(), account.reason.value),
            ("failed", 18.4)
        );
        let steps: Vec<_> = account
            .steps
            .iter()
            .map(|s| (s.name.as_str(), s.took_ns / 1_000_000))
            .collect();
        assert_eq!(steps, [("close", 30), ("lift", 30)]);
        let told: Vec<_> = account
            .moments
            .iter()
            .map(|m| (m.event.tick, m.times))
            .collect();
        // The beginning, its step, the slip in it, the next step, two slips in that, the end.
        assert_eq!(told, [(10, 1), (10, 1), (30, 1), (40, 1), (50, 2), (70, 1)]);
        assert_eq!((goals(&[]).len(), tell(&[])), (0, None));
        // The first step is announced when a goal is accepted, a tick before it runs.
        let mut accepted = events[..2].to_vec();
        accepted.push(at(9, EventKind::STEP, "reach"));
        accepted.extend(&events[2..]);
        let all = goals(&accepted);
        let account = tell(all[1]).expect("told");
        assert_eq!(account.steps[0].name, "reach");
        assert_eq!(account.state, "failed");
    }

    #[test]
    fn a_goal_that_begins_by_opening_only_lets_go() {
        let events = [
            at(9, EventKind::STEP, "reach"),
            at(10, EventKind::GOAL, "running"),
            at(20, EventKind::STEP, "open"),
            at(30, EventKind::GOAL, "failed"),
            at(39, EventKind::STEP, "open"),
            at(40, EventKind::GOAL, "running"),
            at(50, EventKind::STEP, "leave"),
            // Its end was lost.
            at(59, EventKind::STEP, "reach"),
            at(60, EventKind::GOAL, "running"),
        ];
        let told: Vec<_> = goals(&events)
            .into_iter()
            .map(|goal| (goal[0].tick, only_lets_go(goal)))
            .collect();
        assert_eq!(told, [(9, false), (39, true), (59, false)]);
    }
}
