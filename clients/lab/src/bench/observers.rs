//! `atas bench observers`: effect of observers on the tick. Three conditions: one daemon without
//! observers; with eight observers, two of each kind, of which one is frozen and one repeatedly
//! killed and restarted; with the same observers on another daemon and bus. Starting programs
//! disturbs the caches of all processes, so the cost of observing is the ratio of the second to the
//! third condition.
//!
//! * **Invariants:** all conditions use the same daemon in one run, close together in time; the
//!   other daemon runs in all of them.
//! * **Not included:** limits. `tests/benches` check ratios; on a loaded machine they are noise.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use atas_client::percentiles;
use atas_console::arguments::BenchObservers;
use atas_console::{Interrupt, Output, table};
use atas_evaluation::median;
use rustix::process::Signal;
use serde_json::json;
use shm_bus::BusName;
use shm_schemas::Percentiles;

use super::Plan;
use super::machine;
use super::pair::Pair;
use super::punctual::{Ticks, collect_reports};
use super::site::Site;
use atas_processes::child::Child;

/// Observer programs with their arguments; the bus is appended.
const KINDS: [(&str, &str); 4] = [
    ("atas", "status --watch"),
    ("atas", "topic hz tick-report"),
    ("atas-live", "dashboard --port 0"),
    ("atas-live", "foxglove --port 0"),
];
const OBSERVATION_TIME: Duration = Duration::from_millis(500);

type Measure = (&'static str, fn(&Part) -> u64);

pub(super) fn observers(
    arguments: &BenchObservers,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let plan = Plan {
        core: machine::last_core()?,
        window: Duration::from_secs(arguments.seconds),
        repeats: arguments.repeats,
        interrupt,
    };
    let mut pair = start_pair(plan.core, interrupt)?;
    let other = start_pair(machine::other_core(plan.core)?, interrupt)?;
    let [mut alone, mut observed, mut elsewhere] = [const { Vec::new() }; 3];
    for _ in 0..plan.repeats {
        alone.push(Part::measure(&mut pair, &plan, || Ok(()))?);
        let mut crowd = Observers::start(pair.site())?;
        observed.push(Part::measure(&mut pair, &plan, || crowd.restart())?);
        drop(crowd);
        let mut crowd = Observers::start(other.site())?;
        elsewhere.push(Part::measure(&mut pair, &plan, || crowd.restart())?);
    }
    print(&alone, &observed, &elsewhere, output)
}

fn start_pair(core: usize, interrupt: &Interrupt) -> anyhow::Result<Pair> {
    let core = format!("realtime.cpu={core}");
    let mut pair = Pair::start(&["--set", &core], |site, control| {
        Child::start("atasd", control, site.folder())
    })?;
    pair.wait_until_ready(interrupt)?;
    Ok(pair)
}

struct Part {
    wake: Percentiles,
    body: Percentiles,
    missed_ticks: u64,
}

impl Part {
    /// Collects reports during the plan's window; calls `meanwhile` every half second.
    fn measure(
        pair: &mut Pair,
        plan: &Plan<'_>,
        mut meanwhile: impl FnMut() -> anyhow::Result<()>,
    ) -> anyhow::Result<Self> {
        let (mut ticks, mut missed_ticks) = (Ticks::default(), 0);
        let begin = Instant::now();
        while begin.elapsed() < plan.window {
            meanwhile()?;
            missed_ticks += collect_reports(pair, OBSERVATION_TIME, plan, &mut ticks)?.missed_ticks;
        }
        Ok(Self {
            wake: percentiles::from_unsorted(ticks.wake),
            body: percentiles::from_unsorted(ticks.body),
            missed_ticks,
        })
    }
}

/// Observers: of each kind one frozen and one restarted repeatedly.
struct Observers {
    bus: BusName,
    logs: PathBuf,
    frozen: Vec<Child>,
    restarted: Vec<Child>,
}

impl Observers {
    fn start(site: &Site) -> anyhow::Result<Self> {
        let (bus, logs) = (site.bus().clone(), site.folder().to_owned());
        let hanging = start(&bus, &logs)?;
        std::thread::sleep(OBSERVATION_TIME);
        for child in &hanging {
            child.signal(Signal::STOP)?;
        }
        Ok(Self {
            restarted: start(&bus, &logs)?,
            frozen: hanging,
            bus,
            logs,
        })
    }

    fn restart(&mut self) -> anyhow::Result<()> {
        for child in &self.restarted {
            child.signal(Signal::KILL)?;
        }
        self.restarted = start(&self.bus, &self.logs)?;
        Ok(())
    }
}

impl Drop for Observers {
    fn drop(&mut self) {
        for child in &self.frozen {
            // Fails only if it has ended.
            let _ = child.signal(Signal::CONT);
        }
    }
}

fn start(bus: &BusName, logs: &Path) -> anyhow::Result<Vec<Child>> {
    let bus = bus.as_str();
    let one = |(program, words): &(&'static str, &str)| {
        let words: Vec<&str> = words.split(' ').chain(["--bus", bus]).collect();
        Child::start(program, &words, logs)
    };
    KINDS.iter().map(one).collect()
}

fn print(
    alone: &[Part],
    observed: &[Part],
    elsewhere: &[Part],
    output: &mut Output,
) -> anyhow::Result<()> {
    let us = |parts: &[Part], of: fn(&Part) -> u64| {
        let values = parts.iter().map(|part| of(part) as f64 * 1e-3);
        median(values.collect()).unwrap_or(f64::NAN)
    };
    let rows: [Measure; 4] = [
        ("tick body, p50 µs", |part| part.body.p50_ns),
        ("tick body, p99 µs", |part| part.body.p99_ns),
        ("wake-up, p50 µs", |part| part.wake.p50_ns),
        ("wake-up, p99 µs", |part| part.wake.p99_ns),
    ];
    let figures = rows.map(|(name, of)| (name, [alone, observed, elsewhere].map(|p| us(p, of))));
    let missed = |parts: &[Part]| parts.iter().map(|part| part.missed_ticks).sum::<u64>();
    if output.is_json() {
        let [body, body_p99, wake, wake_p99] = figures.map(|(_, [alone, observed, elsewhere])| {
            json!({
                "alone_us": alone, "observed_us": observed, "elsewhere_us": elsewhere,
                "ratio": observed / elsewhere,
            })
        });
        return output.json(&json!({
            "observers": 2 * KINDS.len(),
            "body": { "p50": body, "p99": body_p99 },
            "wake": { "p50": wake, "p99": wake_p99 },
            "missed_ticks": {
                "alone": missed(alone), "observed": missed(observed), "elsewhere": missed(elsewhere),
            },
        }));
    }
    let mut shown = table(&["", "alone", "observed", "elsewhere", "observed/elsewhere"]);
    for (name, [alone, observed, elsewhere]) in figures {
        let text = atas_console::number;
        shown.add_row([
            name.to_owned(),
            text(alone, 1),
            text(observed, 1),
            text(elsewhere, 1),
            text(observed / elsewhere, 2),
        ]);
    }
    output.table(shown)?;
    output.line(format_args!(
        "{} observers: of each kind one is frozen, one restarted twice a second; elsewhere: \
         observers of another daemon; missed ticks {} alone, {} observed, {} elsewhere",
        2 * KINDS.len(),
        missed(alone),
        missed(observed),
        missed(elsewhere)
    ))
}
