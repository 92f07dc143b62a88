//! `atas explain`: why a goal ended as it did, from a recording or from what a running daemon remembers.

use std::path::Path;
use std::time::{Duration, Instant};

use atas_client::{POLL, Session, json};
use atas_console::Output;
use atas_console::arguments::Explain;
use atas_evaluation::figures::{self, Course};
use serde_json::{Value, json};
use shm_bus::BusName;
use shm_schemas::service;

use crate::{picture, plot};

/// How long to wait for past events: the daemon hands them to a new reader when it next speaks (ours).
const PAST: Duration = Duration::from_millis(300);

/// `atas explain`.
pub(crate) fn explain(arguments: &Explain, output: &mut Output) -> anyhow::Result<()> {
    let files = &arguments.files;
    let course = if *files == [Path::new(Explain::LAST)] {
        remembered(&arguments.bus.bus)?
    } else {
        Course::recorded(&plot::name(&files[0]), files)?
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

fn remembered(bus: &BusName) -> anyhow::Result<Course> {
    let session = Session::existing(bus)?;
    let mut stream = session.bus().subscriber(service::MODULE_EVENT)?;
    session.watch_status()?;
    let (mut events, begin) = (Vec::new(), Instant::now());
    while begin.elapsed() < PAST {
        stream.drain(usize::MAX, |event| events.push(*event))?;
        std::thread::sleep(POLL);
    }
    Course::remembered("the last goal", &events)
}

fn told(course: &Course) -> String {
    let account = &course.account;
    let because = if account.reason.is_some() {
        format!(": {}", account.reason)
    } else {
        String::new()
    };
    let mut lines = vec![format!(
        "the goal {} after {:.2} s{because}",
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
