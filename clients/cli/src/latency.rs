//! `atas latency`: timing of the daemon since its start, and of the tick stages over a window.

use std::time::{Duration, Instant};

use atas_client::percentiles;
use atas_client::{POLL, Session, json};
use atas_console::{Interrupt, Output, arguments, table};
use serde_json::{Map, Value, json};
use shm_bus::Subscriber;
use shm_schemas::capacity::STAGES;
use shm_schemas::{Percentiles, Status, StatusFlags, TickReport, service};

/// Window of the stage times. Design choice: 1000 ticks at 1 kHz.
const WINDOW: Duration = Duration::from_secs(1);
/// Most reports read at once: the whole queue.
const BATCH: usize = 256;

pub(crate) fn latency(
    arguments: &arguments::Latency,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let session = Session::existing(&arguments.bus.bus)?;
    let mut reports = session.bus().subscriber(service::TICK_REPORT)?;
    let (mut statuses, mut status) = session.watch_status()?;
    loop {
        let window = Window::collect(&mut reports, interrupt)?;
        // Detects a daemon that has ended; its last status must not appear as current.
        if !statuses.newest(&mut status)? && !interrupt.is_set() {
            (statuses, status) = session.watch_status()?;
        }
        if arguments.watch {
            output.clear()?;
        }
        print(&status, &window, output)?;
        if !arguments.watch || interrupt.is_set() {
            return Ok(());
        }
    }
}

/// Durations of each stage over a window, ns.
#[derive(Debug, Default)]
struct Window {
    stages: [Vec<u64>; STAGES],
}

impl Window {
    fn collect(
        reports: &mut Subscriber<TickReport>,
        interrupt: &Interrupt,
    ) -> anyhow::Result<Self> {
        let mut window = Self::default();
        let begin = Instant::now();
        while begin.elapsed() < WINDOW && !interrupt.is_set() {
            reports.drain(BATCH, |report| window.add(report))?;
            std::thread::sleep(POLL);
        }
        window
            .stages
            .iter_mut()
            .for_each(|stage| stage.sort_unstable());
        Ok(window)
    }

    fn add(&mut self, report: &TickReport) {
        for (stage, ns) in self.stages.iter_mut().zip(report.stage_ns) {
            stage.push(ns.into());
        }
    }

    /// Returns the percentiles of each measured stage.
    fn figures(&self) -> impl Iterator<Item = (&'static str, Percentiles)> {
        let figures = self
            .stages
            .iter()
            .map(|stage| percentiles::from_sorted(stage));
        TickReport::STAGE_NAMES
            .into_iter()
            .zip(figures)
            .filter(|(_, figures)| figures.max_ns > 0)
    }
}

fn since_start(status: &Status) -> [(&'static str, Percentiles); 4] {
    [
        ("wake-up", status.wake),
        ("frame age", status.frame_age),
        ("tick body", status.tick),
        ("sensor to command", status.sensor_to_command),
    ]
}

fn print(status: &Status, window: &Window, output: &mut Output) -> anyhow::Result<()> {
    if output.is_json() {
        return output.json(&as_json(status, window));
    }
    output.line(format_args!(
        "{} Hz{}: {} ticks, {} missed, {} late, {} records dropped",
        status.rate_hz,
        conditions(status.flags),
        status.ticks,
        status.missed_ticks,
        status.late_ticks,
        status.dropped_records
    ))?;
    let mut rows = table(&["µs", "p50", "p99", "p99.9", "max", "count"]);
    let stages = window
        .figures()
        .map(|(name, figures)| (format!("  {name}, last second"), figures));
    let whole = since_start(status).map(|(name, figures)| (name.to_owned(), figures));
    for (name, figures) in whole.into_iter().chain(stages) {
        rows.add_row(row(name, &figures));
    }
    output.table(rows)
}

fn row(name: String, figures: &Percentiles) -> [String; 6] {
    let microseconds = |ns: u64| format!("{:.2}", ns as f64 * 1e-3);
    [
        name,
        microseconds(figures.p50_ns),
        microseconds(figures.p99_ns),
        microseconds(figures.p999_ns),
        microseconds(figures.max_ns),
        figures.count.to_string(),
    ]
}

fn conditions(flags: u32) -> String {
    let known = [
        (
            StatusFlags::LOCKSTEP,
            ", lock-step (times are not meaningful)",
        ),
        (StatusFlags::PHASE_LOCKED, ", phase-locked"),
        (StatusFlags::DEGRADED, ", DEGRADED (see `atas doctor`)"),
    ];
    let set = known.iter().filter(|(flag, _)| flags & flag != 0);
    set.map(|(_, text)| *text).collect()
}

fn as_json(status: &Status, window: &Window) -> Value {
    let stages: Map<String, Value> = window
        .figures()
        .map(|(name, figures)| (name.to_owned(), json::percentiles(&figures)))
        .collect();
    json!({
        "rate_hz": status.rate_hz,
        "phase_locked": status.flags & StatusFlags::PHASE_LOCKED != 0,
        "degraded": status.flags & StatusFlags::DEGRADED != 0,
        "lockstep": status.flags & StatusFlags::LOCKSTEP != 0,
        "ticks": status.ticks,
        "missed_ticks": status.missed_ticks,
        "late_ticks": status.late_ticks,
        "dropped_records": status.dropped_records,
        "wake": json::percentiles(&status.wake),
        "frame_age": json::percentiles(&status.frame_age),
        "tick": json::percentiles(&status.tick),
        "sensor_to_command": json::percentiles(&status.sensor_to_command),
        "stages": stages,
    })
}
