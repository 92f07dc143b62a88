//! Bench figures as tables for people.

use atas_console::{Output, number, table};
use serde_json::Value;
use shm_schemas::TickReport;

const NOTHING: &str = "–";

pub(super) fn print(figures: &Value, output: &mut Output) -> anyhow::Result<()> {
    let text = |key: &str| figures[key].as_str().unwrap_or(NOTHING).to_owned();
    let heading = [text("machine"), text("kernel")].join(", ");
    output.line(format_args!("{heading}; ticks on core {}", figures["core"]))?;
    wake(figures, output)?;
    durations(figures, output)?;
    single(figures, output)
}

fn wake(figures: &Value, output: &mut Output) -> anyhow::Result<()> {
    let mut rows = table(&["wake-up latency, µs", "p50", "p99", "p99.9", "max"]);
    for (state, name) in [("idle", "idle"), ("loaded", "under load")] {
        let of = &figures["wake"][state];
        if of.is_null() {
            continue;
        }
        for (what, key, digits) in [
            ("daemon", "daemon_us", 2),
            ("bare loop", "bare_loop_us", 2),
            ("bare loop, cores awake", "bare_loop_awake_us", 2),
            ("bare loop, spinning", "bare_loop_spinning_us", 2),
            ("cyclictest", "cyclictest_us", 2),
            ("daemon / cyclictest", "to_cyclictest", 4),
            ("daemon / bare loop", "to_bare_loop", 4),
            ("daemon / spinning loop", "to_bare_loop_spinning", 4),
        ] {
            rows.add_row(row(format!("{name}: {what}"), &of[key], digits));
        }
    }
    let drowsy = &figures["wake"]["not_kept_awake_us"];
    rows.add_row(row("idle: daemon, keep_awake off".into(), drowsy, 2));
    output.table(rows)
}

fn durations(figures: &Value, output: &mut Output) -> anyhow::Result<()> {
    let mut rows = table(&["µs", "p50", "p99", "p99.9", "max"]);
    let ages = &figures["frame_age_us"];
    rows.add_row(row("frame age, phase-locked".into(), &ages["locked"], 1));
    rows.add_row(row(
        "frame age, phase-locked, under load".into(),
        &ages["loaded"],
        1,
    ));
    rows.add_row(row("frame age, free-running".into(), &ages["free"], 1));
    let answers = &figures["sensor_to_command_us"];
    rows.add_row(row(
        "sensor to command, phase-locked".into(),
        &answers["locked"],
        1,
    ));
    rows.add_row(row(
        "sensor to command, free-running".into(),
        &answers["free"],
        1,
    ));
    rows.add_row(row(
        "tick body, back to back".into(),
        &figures["tick_us"],
        2,
    ));
    for name in TickReport::STAGE_NAMES {
        let of = &figures["tick_stages_us"][name];
        if !of.is_null() {
            rows.add_row(row(format!("  {name}"), of, 2));
        }
    }
    let daemon = &figures["daemon"];
    rows.add_row(row(
        "tick body, in the daemon at rest".into(),
        &daemon["tick_us"],
        2,
    ));
    output.table(rows)
}

fn single(figures: &Value, output: &mut Output) -> anyhow::Result<()> {
    let mut rows = table(&["", ""]);
    let daemon = &figures["daemon"];
    let transports = &figures["transports_us"];
    let answers = &figures["sensor_to_command_us"];
    let frame = format!("one way of {} bytes, µs:", transports["payload_bytes"]);
    let lines = [
        (
            "allocations per tick".to_owned(),
            &figures["allocs_per_tick"],
            3,
        ),
        (
            "system calls per tick, incl. sleep".into(),
            &figures["syscalls_per_tick"],
            3,
        ),
        (
            "instructions per tick".into(),
            &figures["instructions_per_tick"],
            0,
        ),
        ("page faults in all ticks".into(), &daemon["page_faults"], 0),
        (
            "tick time, recording / not".into(),
            &figures["recording"]["tick_ratio"],
            3,
        ),
        (
            "  of this, tick body".into(),
            &figures["recording"]["body_ratio"],
            3,
        ),
        (
            "recording after the body, µs".into(),
            &figures["recording"]["after_body_us"],
            2,
        ),
        (
            "sensor to command, polling, µs".into(),
            &answers["polling"],
            1,
        ),
        ("  bare ping-pong, µs".into(), &answers["ping_pong"], 1),
        (
            "  ratio to ping-pong and body".into(),
            &figures["sensor_to_command_ratio"],
            2,
        ),
        (format!("{frame} iceoryx2"), &transports["iceoryx2"], 2),
        (
            format!("{frame} Unix socket"),
            &transports["unix_socket"],
            2,
        ),
        (format!("{frame} zenoh, TCP"), &transports["zenoh"], 2),
        (
            format!("{frame} zenoh, shared memory"),
            &transports["zenoh_shared_memory"],
            2,
        ),
        (
            "CPU of the ticks, %".into(),
            &figures["wake"]["cpu_percent"],
            1,
        ),
        ("CPU of the daemon, %".into(), &daemon["cpu_percent"], 1),
        ("resident memory, MiB".into(), &daemon["resident_mib"], 1),
        (
            "start to first tick, ms".into(),
            &daemon["first_tick_ms"],
            1,
        ),
        ("missed ticks".into(), &daemon["missed_ticks"], 0),
    ];
    for (name, value, digits) in lines {
        rows.add_row([name, figure(value, digits)]);
    }
    output.table(rows)
}

fn row(name: String, of: &Value, digits: usize) -> [String; 5] {
    let at = |key: &str| figure(&of[key], digits);
    [name, at("p50"), at("p99"), at("p999"), at("max")]
}

fn figure(value: &Value, digits: usize) -> String {
    let value = value.as_f64();
    value.map_or(NOTHING.to_owned(), |value| number(value, digits))
}
