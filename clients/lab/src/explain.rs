//! `atas explain`: explains how a goal ended, from a recording or from the event history of a
//! running daemon.

use std::path::Path;
use std::time::{Duration, Instant};

use atas_client::{POLL, Session, json};
use atas_console::arguments::Explain;
use atas_console::{Output, number, table};
use atas_evaluation::figures::{self, Choice, Course, Goal, Goals};
use serde_json::{Value, json};
use shm_bus::BusName;
use shm_schemas::service;

use crate::{picture, plot};

/// Time to wait for past events, which the daemon sends to a new reader with its next message
/// (design choice).
const PAST: Duration = Duration::from_millis(300);

pub(crate) fn explain(arguments: &Explain, output: &mut Output) -> anyhow::Result<()> {
    let files = &arguments.files;
    let choice = Choice::said(arguments.goal.as_deref());
    let is_live = *files == [Path::new(Explain::LAST)];
    if arguments.list {
        let goals = if is_live {
            remembered(&arguments.bus.bus)?
        } else {
            Goals::recorded(&plot::name(&files[0]), files)?
        };
        return list(&goals, output);
    }
    let course = if is_live {
        Course::remembered("running daemon", &remembered(&arguments.bus.bus)?, &choice)?
    } else {
        Course::recorded(&plot::name(&files[0]), files, &choice)?
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
    output.line(told(&course))?;
    drawn.map_or(Ok(()), |drawn| output.line(format_args!("wrote {drawn}")))
}

fn remembered(bus: &BusName) -> anyhow::Result<Goals> {
    let session = Session::existing(bus)?;
    let mut stream = session.bus().subscriber(service::MODULE_EVENT)?;
    let (mut statuses, mut status) = session.watch_status()?;
    let (mut events, begin) = (Vec::new(), Instant::now());
    while begin.elapsed() < PAST {
        stream.drain(usize::MAX, |event| events.push(*event))?;
        statuses.newest(&mut status)?;
        std::thread::sleep(POLL);
    }
    Ok(Goals::remembered("the running daemon", events, &status))
}

fn list(goals: &Goals, output: &mut Output) -> anyhow::Result<()> {
    let goals = goals.list();
    if output.is_json() {
        let goals: Vec<Value> = goals.iter().map(listed).collect();
        return output.json(&json!({ "goals": goals }));
    }
    let mut rows = table(&["goal", "task", "hand", "from s", "took s", "state", "why"]);
    for goal in &goals {
        let account = &goal.account;
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

fn listed(goal: &Goal<'_>) -> Value {
    json!({
        "goal": goal.number,
        "task": goal.task,
        "hand": goal.hand.name(),
        "from_s": goal.from_s,
        "took_s": goal.account.took_s(),
        "state": goal.account.state,
        "reason": json::reason(&goal.account.reason),
    })
}

fn told(course: &Course) -> String {
    let account = &course.account;
    let because = if account.reason.is_some() {
        format!(": {}", account.reason)
    } else {
        String::new()
    };
    let mut lines = vec![format!(
        "{}: {} after {:.2} s{because}",
        course.title(),
        account.state,
        course.took_s()
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
            course.sentence(moment)
        ));
    }
    lines.join("\n")
}

fn as_json(course: &Course) -> Value {
    let account = &course.account;
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
        value["sentence"] = moment.sentence.trim().into();
        value["times"] = moment.times.into();
        value["evidence"] = course.felt(&moment.event).into();
        value
    });
    json!({
        "goal": course.number,
        "task": course.task,
        "state": account.state,
        "reason": json::reason(&account.reason),
        "took_s": course.took_s(),
        "steps": steps.collect::<Vec<_>>(),
        "moments": moments.collect::<Vec<_>>(),
    })
}

fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}
