//! `atas explain`: explains how a goal ended, from a recording or from the event history of a
//! running daemon.

use std::path::Path;
use std::time::{Duration, Instant};

use atas_client::{POLL, Session, json};
use atas_console::arguments::Explain;
use atas_console::{Output, number, table};
use atas_evaluation::figures::{self, Goal, GoalSelection, GoalTrace, Goals};
use serde_json::{Value, json};
use shm_bus::BusName;
use shm_schemas::service;

use crate::{picture, plot};

/// Time to wait for past events, which the daemon sends to a new reader with its next message
/// (design choice).
const HISTORY_WAIT: Duration = Duration::from_millis(300);

pub(crate) fn explain(arguments: &Explain, output: &mut Output) -> anyhow::Result<()> {
    let files = &arguments.files;
    let choice = GoalSelection::parse(arguments.goal.as_deref());
    let is_live = *files == [Path::new(Explain::LAST)];
    if arguments.list {
        let goals = if is_live {
            goals_from_daemon(&arguments.bus.bus)?
        } else {
            Goals::from_recording(&plot::run_name(&files[0]), files)?
        };
        return list(&goals, output);
    }
    let course = if is_live {
        GoalTrace::from_events(
            "running daemon",
            &goals_from_daemon(&arguments.bus.bus)?,
            &choice,
        )?
    } else {
        GoalTrace::from_recording(&plot::run_name(&files[0]), files, &choice)?
    };
    if let Some(out) = &arguments.out {
        picture::write(out, &figures::explained(&course)?)?;
    }
    let drawn = arguments.out.as_ref().map(|out| out.display().to_string());
    if output.is_json() {
        let mut value = as_json(&course);
        value["picture"] = drawn.into();
        return output.json(&value);
    }
    output.line(as_text(&course))?;
    drawn.map_or(Ok(()), |drawn| output.line(format_args!("wrote {drawn}")))
}

fn goals_from_daemon(bus: &BusName) -> anyhow::Result<Goals> {
    let session = Session::existing(bus)?;
    let mut stream = session.bus().subscriber(service::MODULE_EVENT)?;
    let (mut statuses, mut status) = session.watch_status()?;
    let (mut events, begin) = (Vec::new(), Instant::now());
    while begin.elapsed() < HISTORY_WAIT {
        stream.drain(usize::MAX, |event| events.push(*event))?;
        statuses.newest(&mut status)?;
        std::thread::sleep(POLL);
    }
    Ok(Goals::from_events("the running daemon", events, &status))
}

fn list(goals: &Goals, output: &mut Output) -> anyhow::Result<()> {
    let goals = goals.list();
    if output.is_json() {
        let goals: Vec<Value> = goals.iter().map(goal_json).collect();
        return output.json(&json!({ "goals": goals }));
    }
    let mut rows = table(&["goal", "task", "hand", "from s", "took s", "state", "why"]);
    for goal in &goals {
        let account = &goal.summary;
        let why = account.reason.is_some().then(|| account.reason.to_string());
        rows.add_row([
            goal.number.to_string(),
            goal.task.unwrap_or("–").to_owned(),
            goal.hand.to_string(),
            number(goal.from_s, 2),
            number(account.took_s(), 2),
            account.state.clone(),
            why.unwrap_or_default(),
        ]);
    }
    output.table(rows)
}

fn goal_json(goal: &Goal<'_>) -> Value {
    json!({
        "goal": goal.number,
        "task": goal.task,
        "hand": goal.hand.name(),
        "from_s": goal.from_s,
        "took_s": goal.summary.took_s(),
        "state": goal.summary.state,
        "reason": json::reason(&goal.summary.reason),
    })
}

fn as_text(course: &GoalTrace) -> String {
    let account = &course.summary;
    let because = if account.reason.is_some() {
        format!(": {}", account.reason)
    } else {
        String::new()
    };
    let mut lines = vec![format!(
        "{}: {} after {:.2} s{because}",
        course.title(),
        account.state,
        course.duration_s()
    )];
    let steps = account.steps.iter();
    let steps = steps.map(|step| format!("{} {:.2} s", step.name, seconds(step.took_ns)));
    lines.push(format!("steps: {}", steps.collect::<Vec<_>>().join(", ")));
    for moment in &account.moments {
        let event = &moment.event;
        lines.push(format!(
            "{:9.3} s  tick {:<8} {}",
            course.since_s(event.stamp.captured_ns),
            event.tick,
            course.event_text(moment)
        ));
    }
    lines.join("\n")
}

fn as_json(course: &GoalTrace) -> Value {
    let account = &course.summary;
    let steps = account.steps.iter().map(|step| {
        json!({
            "name": step.name,
            "hand": step.hand.name(),
            "from_s": course.since_s(step.captured_ns),
            "took_s": seconds(step.took_ns),
        })
    });
    let moments = account.moments.iter().map(|moment| {
        let mut value = json::event(&moment.event);
        value["t_s"] = course.since_s(moment.event.stamp.captured_ns).into();
        value["sentence"] = moment.text.trim().into();
        value["times"] = moment.times.into();
        value["evidence"] = course.measured(&moment.event).into();
        value
    });
    json!({
        "goal": course.number,
        "task": course.task,
        "state": account.state,
        "reason": json::reason(&account.reason),
        "took_s": course.duration_s(),
        "steps": steps.collect::<Vec<_>>(),
        "moments": moments.collect::<Vec<_>>(),
    })
}

fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}
