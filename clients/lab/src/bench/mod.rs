//! `atas bench`: timing of the daemon on this machine, compared with references in one run.
//!
//! ```text
//!  repeats × ┬ cyclictest, same core ─┐
//!            ├ bare loop, same core ──┤
//!            ├ daemon, phase-locked ──┼─▶ medians ─▶ report: JSON, tables
//!            ├ daemon, free-running ──┤
//!            └ response and echo ─────┘             the first three again under load
//!  once: counts of a tick, transports
//! ```
//!
//! * **In:** duration, number of repeats; installed reference programs. **Out:** figures.
//! * **Invariants:** compared loops run in turn on the same core. Every wait has a time limit. A
//!   missing figure is `null`, and `not_measured` gives the reason. Every exit removes processes
//!   and bus; after `kill -9` the next bench or demo removes the shared memory.
//! * **Not included:** limits, as absolute times depend on the machine; `tests/benches` check
//!   ratios and counts.

mod bare;
mod body;
mod counts;
mod cyclictest;
mod echo;
mod load;
mod machine;
mod observers;
mod pair;
mod punctual;
mod report;
mod response;
mod restarts;
mod site;
mod stops;
mod tables;
mod tool;
mod transport;

use std::time::Duration;

use atas_console::arguments::{Bench, BenchLatency};
use atas_console::{Interrupt, Output};

use counts::Counts;
use punctual::{Loaded, Repeat};
use report::Report;
use tool::Notes;
use transport::Transports;

const SECONDS: u64 = 10;
const SECONDS_SHORT: u64 = 2;

struct Plan<'a> {
    /// Core of the daemon's ticks and of the references.
    core: usize,
    window: Duration,
    repeats: u32,
    interrupt: &'a Interrupt,
}

pub(crate) fn bench(
    what: &Bench,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    match what {
        Bench::Latency(arguments) => latency(arguments, interrupt, output),
        Bench::Stop(arguments) => stops::stops(arguments, interrupt, output),
        Bench::Restart(arguments) => restarts::restarts(arguments, interrupt, output),
        Bench::Observers(arguments) => observers::observers(arguments, interrupt, output),
        Bench::Echo { by, bus, socket } => echo::run(*by, bus, socket, interrupt),
    }
}

fn latency(
    arguments: &BenchLatency,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let usual = if arguments.short {
        SECONDS_SHORT
    } else {
        SECONDS
    };
    let plan = Plan {
        core: machine::last_core()?,
        window: Duration::from_secs(arguments.seconds.unwrap_or(usual)),
        repeats: arguments.repeats,
        interrupt,
    };
    let report = measure(&plan)?;
    if output.is_json() {
        output.json(&report.json(&plan))
    } else {
        report.print(&plan, output)
    }
}

fn measure(plan: &Plan<'_>) -> anyhow::Result<Report> {
    let mut notes = Notes::default();
    let mut idle = Vec::new();
    let mut loaded = Vec::new();
    for index in 1..=plan.repeats {
        notes.progress(format_args!("repeat {index} of {}", plan.repeats));
        idle.push(Repeat::measure(plan, &mut notes)?);
        loaded.extend(Loaded::measure(plan, &mut notes)?);
    }
    notes.progress("counts of a tick");
    let counts = Counts::measure(plan, &mut notes)?;
    notes.progress("transports");
    let transports = Transports::measure(plan, &mut notes)?;
    Ok(Report {
        idle,
        loaded,
        counts,
        transports,
        notes,
    })
}
