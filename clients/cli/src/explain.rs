//! `atas explain`: why a goal ended as it did, from a recording or from what a running daemon remembers.

use std::collections::HashMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use atas_client::account::{self, Account, Moment};
use atas_client::{POLL, Session, json, words};
use atas_console::arguments::Explain;
use atas_console::{Ended, Exit, Output};
use atas_recording::Rows;
use serde_json::{Value, json};
use shm_bus::BusName;
use shm_schemas::{EventKind, ModuleEvent, service};

/// How long to wait for past events: the daemon hands them to a new reader when it next speaks (ours).
const PAST: Duration = Duration::from_millis(300);
/// What is said instead of a file.
const LAST: &str = "last";

/// What is known of a run: its events, and by their sequence what the hand felt when a module was switched on.
#[derive(Default)]
struct Known {
    events: Vec<ModuleEvent>,
    felt: HashMap<u64, String>,
}

/// `atas explain`.
pub(crate) fn explain(arguments: &Explain, output: &mut Output) -> anyhow::Result<()> {
    let known = if arguments.files == [PathBuf::from(LAST)] {
        remembered(&arguments.bus.bus)?
    } else {
        recorded(&arguments.files)?
    };
    let Some(account) = account::tell(account::last_goal(&known.events)) else {
        return Err(Ended::with(
            Exit::Failed,
            "there is no goal to explain: none began in what is known",
        ));
    };
    if output.is_json() {
        return output.json(&as_json(&account, &known));
    }
    output.line(told(&account, &known))
}

fn recorded(files: &[PathBuf]) -> anyhow::Result<Known> {
    let mut known = Known::default();
    for row in Rows::open(files)? {
        let row = row?;
        for event in &row.events {
            let report = row
                .report
                .as_deref()
                .filter(|_| event.kind == EventKind::MODULE_ON);
            if let (Some(report), Some(hand)) = (report, event.hand.index()) {
                let felt = words::evidence(event.module, &report.hands[hand]);
                known.felt.insert(event.stamp.sequence, felt);
            }
            known.events.push(*event);
        }
    }
    Ok(known)
}

fn remembered(bus: &BusName) -> anyhow::Result<Known> {
    let session = Session::existing(bus)?;
    let mut stream = session.bus().subscriber(service::MODULE_EVENT)?;
    session.watch_status()?;
    let (mut known, begin) = (Known::default(), Instant::now());
    while begin.elapsed() < PAST {
        stream.drain(usize::MAX, |event| known.events.push(*event))?;
        std::thread::sleep(POLL);
    }
    Ok(known)
}

fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}

fn told(account: &Account, known: &Known) -> String {
    let [begin_ns, end_ns] = account.span_ns;
    let because = if account.reason.is_some() {
        format!(": {}", account.reason)
    } else {
        String::new()
    };
    let mut lines = vec![format!(
        "the goal {} after {:.2} s{because}",
        account.state,
        seconds(end_ns.saturating_sub(begin_ns))
    )];
    let steps = account.steps.iter();
    let steps = steps.map(|step| format!("{} {:.2} s", step.name, seconds(step.took_ns)));
    lines.push(format!("steps: {}", steps.collect::<Vec<_>>().join(", ")));
    for moment in &account.moments {
        let at_s = seconds(moment.event.stamp.captured_ns.saturating_sub(begin_ns));
        lines.push(format!(
            "{at_s:9.3} s  tick {:<8} {}",
            moment.event.tick,
            sentence(moment, known)
        ));
    }
    lines.join("\n")
}

fn sentence(moment: &Moment, known: &Known) -> String {
    let often = match moment.times {
        1 => String::new(),
        times => format!(", {times} times in this step"),
    };
    let felt = known.felt.get(&moment.event.stamp.sequence);
    let felt = felt.map_or(String::new(), |felt| format!(" ({felt})"));
    format!("{}{often}{felt}", moment.sentence)
}

fn as_json(account: &Account, known: &Known) -> Value {
    let [begin_ns, end_ns] = account.span_ns;
    let since_s = |ns: u64| seconds(ns.saturating_sub(begin_ns));
    let steps = account.steps.iter().map(|step| {
        json!({
            "name": step.name,
            "hand": step.hand.name(),
            "from_s": since_s(step.captured_ns),
            "took_s": seconds(step.took_ns),
        })
    });
    let moments = account.moments.iter().map(|moment| {
        let mut value = json::event(&moment.event);
        value["t_s"] = since_s(moment.event.stamp.captured_ns).into();
        value["sentence"] = moment.sentence.trim().into();
        value["times"] = moment.times.into();
        value["evidence"] = known.felt.get(&moment.event.stamp.sequence).cloned().into();
        value
    });
    json!({
        "state": account.state,
        "reason": json::reason(&account.reason),
        "took_s": since_s(end_ns),
        "steps": steps.collect::<Vec<_>>(),
        "moments": moments.collect::<Vec<_>>(),
    })
}
