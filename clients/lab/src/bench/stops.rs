//! `atas bench stop`: latency of the software stop under overload. Clients flood a daemon with
//! goals whose validation takes longest, occupy all client slots, and one client is frozen while
//! joining. Meanwhile the daemon is stopped and recovered repeatedly.
//!
//! * **Measured:** ticks from the request to the first command in SAFE_STOP, without the tick in
//!   progress.
//! * **Invariants:** the flooding clients keep their requests pending. A stop without a command
//!   within 1 s counts as failed.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use atas_client::{POLL, percentiles};
use atas_console::arguments::BenchStop;
use atas_console::{Interrupt, Output, table};
use rustix::process::Signal;
use serde_json::json;
use shm_bus::{Bus, BusName, PendingGoal, Realtime, now_ns, stop};
use shm_schemas::{
    ControlOp, ControlRequest, GoalKind, GoalRequest, Hand, Mode, Status, StopOutcome, Text,
    TickReport,
};

use super::pair::Pair;
use super::site::Site;
use atas_processes::child::Child;

/// Number of flooding clients, and of pending goals of each.
const CLIENTS: usize = 6;
const PENDING: usize = 2;
/// Longest time until a stop is acknowledged and reaches the commands.
const STOP_TIMEOUT: Duration = Duration::from_secs(1);
/// Timeouts of a control request and of the return to READY.
const REPLY_TIMEOUT: Duration = Duration::from_millis(500);
const READY_TIMEOUT: Duration = Duration::from_secs(30);
/// Most reports read at once: the queue length.
const AT_ONCE: usize = 256;
/// Specified limit, ticks.
const LIMIT_TICKS: u64 = 3;
/// Steps per hand of the task with the longest validation: the limit of a task minus the final
/// release.
const STEPS: usize = 31;

pub(super) fn stops(
    arguments: &BenchStop,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let mut pair = Pair::start(&[], start_daemon)?;
    pair.wait_until_ready(interrupt)?;
    let control = Bus::open(pair.site().bus(), "bench", Realtime::No)?;
    let flood = Flood::start(pair.site().bus());
    let frozen = freeze_a_client(&pair)?;
    let mut seen = Vec::new();
    for _ in 0..arguments.count {
        interrupt.check("the daemon was being stopped")?;
        seen.push(stop_once(&mut pair)?);
        recover(&mut pair, &control, interrupt)?;
    }
    let goals = flood.end();
    frozen.signal(Signal::CONT)?;
    print(&seen, goals, output)
}

/// Starts a daemon with a task of the longest possible validation.
fn start_daemon(site: &Site, control: &[&str]) -> anyhow::Result<Child> {
    let path = site.folder().join("endless.toml");
    std::fs::write(&path, endless_task())?;
    let path = path.display().to_string();
    Child::start(
        "atasd",
        &[control, &["--config", &path]].concat(),
        site.folder(),
    )
}

/// Returns a task in which both hands move back and forth without synchronisation: validation must
/// compare all pairs of postures.
fn endless_task() -> String {
    let step = |index: usize| {
        let waypoint = ["before-source", "home"][index % 2];
        format!(
            "{{ step = \"s{index}\", motion = \"reach\", waypoint = \"{waypoint}\", modules = [\"carry\"], transition = \"arrived\", \
             timeout_s = 20.0 }}"
        )
    };
    let steps: Vec<String> = (0..STEPS).map(step).collect();
    let track = steps.join(", ");
    format!("[tasks.endless]\nacting = [{track}]\nhelping = [{track}]\n")
}

struct StopResult {
    /// Ticks until the command in SAFE_STOP; `None` if it did not come.
    ticks: Option<u64>,
    answered_ns: u64,
}

fn stop_once(pair: &mut Pair) -> anyhow::Result<StopResult> {
    pair.reports.drain(AT_ONCE, |_| {})?;
    let asked_ns = now_ns();
    let answer = stop::request(pair.site().bus(), "bench", STOP_TIMEOUT);
    let answered_ns = now_ns() - asked_ns;
    let has_stopped = answer.is_ok_and(|answer| answer.outcome == StopOutcome::STOPPED);
    let (mut before, mut stopped) = (0, false);
    while has_stopped && !stopped && now_ns() - asked_ns < STOP_TIMEOUT.as_nanos() as u64 {
        pair.reports.drain(AT_ONCE, |report: &TickReport| {
            if stopped || report.stamp.captured_ns <= asked_ns {
                return;
            }
            stopped = report.mode == Mode::SAFE_STOP;
            before += 1;
        })?;
        std::thread::sleep(POLL);
    }
    Ok(StopResult {
        ticks: stopped.then_some(before),
        answered_ns,
    })
}

/// Recovers the daemon; requests are repeated because the flood may reject them.
fn recover(pair: &mut Pair, control: &Bus, interrupt: &Interrupt) -> anyhow::Result<()> {
    let request = ControlRequest {
        op: ControlOp::RECOVER,
        ..ControlRequest::default()
    };
    let begin_ns = now_ns();
    loop {
        if let Ok(client) = control.control_client() {
            let _asked = client.call(&request, REPLY_TIMEOUT);
        }
        let is_armed = |status: &Status| matches!(status.mode, Mode::READY | Mode::RUN);
        if pair.wait_until(REPLY_TIMEOUT, interrupt, is_armed)? {
            return Ok(());
        }
        let limit_ns = READY_TIMEOUT.as_nanos() as u64;
        anyhow::ensure!(
            now_ns() - begin_ns < limit_ns,
            "the daemon did not recover within {READY_TIMEOUT:?}: mode {} ({})",
            pair.status.mode,
            pair.status.reason
        );
    }
}

/// Starts a client and freezes it while it joins, with all resources it holds then.
fn freeze_a_client(pair: &Pair) -> anyhow::Result<Child> {
    let bus = pair.site().bus().as_str();
    let child = Child::start(
        "atas",
        &["status", "--watch", "--bus", bus],
        pair.site().folder(),
    )?;
    std::thread::sleep(Duration::from_millis(5));
    child.signal(Signal::STOP)?;
    Ok(child)
}

struct Flood {
    threads: Vec<JoinHandle<()>>,
    is_ending: Arc<AtomicBool>,
    sent: Arc<AtomicU64>,
}

impl Flood {
    fn start(bus: &BusName) -> Self {
        let (ends, sent) = <(Arc<AtomicBool>, Arc<AtomicU64>)>::default();
        let thread = |index| {
            let (bus, ends, sent) = (bus.clone(), Arc::clone(&ends), Arc::clone(&sent));
            std::thread::spawn(move || {
                // Fails if no client slot is left; the other threads continue the flood.
                let _served = flood(&bus, index, &ends, &sent);
            })
        };
        let threads = (0..CLIENTS).map(thread).collect();
        Self {
            threads,
            is_ending: ends,
            sent,
        }
    }

    fn end(self) -> u64 {
        self.is_ending.store(true, Ordering::Relaxed);
        for thread in self.threads {
            // Goals sent before a panic still count.
            let _ended = thread.join();
        }
        self.sent.load(Ordering::Relaxed)
    }
}

fn flood(
    bus: &BusName,
    index: usize,
    is_ending: &AtomicBool,
    sent: &AtomicU64,
) -> anyhow::Result<()> {
    let bus = Bus::open(bus, "flood", Realtime::No)?;
    let client = bus.goal_client()?;
    let mut pending: Vec<PendingGoal> = Vec::new();
    let mut goal_id = (index as u64) << 32;
    while !is_ending.load(Ordering::Relaxed) {
        while pending.len() < PENDING {
            goal_id += 1;
            match client.send(&goal(goal_id)) {
                Ok(goal) => pending.push(goal),
                Err(_) => break,
            }
            sent.fetch_add(1, Ordering::Relaxed);
        }
        pending.retain_mut(|goal| match goal.next() {
            Ok(Some(update)) => !update.state.is_final(),
            Ok(None) => !goal.has_ended(),
            Err(_) => false,
        });
        std::thread::sleep(POLL);
    }
    Ok(())
}

/// Returns a goal. Every eighth has the longest validation; the others are rejected or run.
fn goal(goal_id: u64) -> GoalRequest {
    let own = goal_id.is_multiple_of(8);
    GoalRequest {
        goal_id,
        kind: if own {
            GoalKind::CUSTOM
        } else {
            GoalKind::GRASP
        },
        task: Text::new(if own { "endless" } else { "" }),
        hand: Hand::RIGHT,
        from_m: [0.30, -0.28, 0.06],
        to_m: [0.30, 0.28, 0.12],
        width_m: 0.05,
        helper_width_m: 0.06,
        lift_m: 0.03,
        ..GoalRequest::default()
    }
}

fn print(seen: &[StopResult], goals: u64, output: &mut Output) -> anyhow::Result<()> {
    let mut ticks: Vec<u64> = seen.iter().filter_map(|seen| seen.ticks).collect();
    let within = ticks.iter().filter(|ticks| **ticks <= LIMIT_TICKS).count();
    ticks.sort_unstable();
    let tick = percentiles::from_sorted(&ticks);
    let answered = percentiles::from_unsorted(seen.iter().map(|seen| seen.answered_ns).collect());
    let us = |ns: u64| ns as f64 * 1e-3;
    if output.is_json() {
        output.json(&json!({
            "stops": seen.len(),
            "seen": ticks.len(),
            "within_3_ticks": within,
            "ticks": {"p50": tick.p50_ns, "p99": tick.p99_ns, "max": tick.max_ns},
            "answered_us": {
                "p50": us(answered.p50_ns), "p99": us(answered.p99_ns), "max": us(answered.max_ns),
            },
            "goals": goals,
        }))?;
    } else {
        let mut rows = table(&["", "p50", "p99", "max"]);
        let row = |name: &str, [p50, p99, max]: [f64; 3], digits: usize| {
            let text = |value| atas_console::number(value, digits);
            [name.to_owned(), text(p50), text(p99), text(max)]
        };
        let counts = [tick.p50_ns, tick.p99_ns, tick.max_ns].map(|ticks| ticks as f64);
        let times = [answered.p50_ns, answered.p99_ns, answered.max_ns].map(us);
        rows.add_row(row("ticks until safe stop", counts, 0));
        rows.add_row(row("acknowledged after, µs", times, 0));
        output.table(rows)?;
        output.line(format_args!(
            "{within} of {} stops within {LIMIT_TICKS} ticks, during {goals} goals of {CLIENTS} \
             clients",
            seen.len()
        ))?;
    }
    anyhow::ensure!(
        within == seen.len(),
        "stop latency exceeded: {} stops took more than {LIMIT_TICKS} ticks or failed",
        seen.len() - within
    );
    Ok(())
}
