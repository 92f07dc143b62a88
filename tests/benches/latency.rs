//! Runs `atas bench latency --short` and holds what must not get worse: ratios and counts, never microseconds, which are
//! printed with the machine and kept in `target/bench/latency.jsonl`, a line per run.
//!
//! `cargo bench -p system-tests --bench latency` after `cargo build --workspace`.
//!
//! A bound is the aim with room for a busy machine of two cores; the README states what a quiet one reaches.
//! What could not be measured here (`null`) is told and not held.

#![expect(clippy::print_stdout, reason = "figures are the product of a bench")]

use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::SystemTime;

use serde_json::{Value, json};
use system_tests::binary;

/// Instructions of a tick: mean over the first 3,000 of a grasp, dev profile, rustc 1.95, callgrind 3.19 on x86-64. A robot whose
/// joints and fingers are counted at run time costs a quarter more of them than one whose numbers the compiler knew (76,900); a second
/// patch of each fingertip, filtered longer, from which friction is read whatever noise does to the first, costs a sixth while it is
/// sheared, and holding the skin against the joints a twelfth.
const INSTRUCTIONS: f64 = 107_800.0;

/// One figure with its bounds.
struct Gate {
    name: &'static str,
    of: fn(&Value) -> Option<f64>,
    least: f64,
    most: f64,
    /// Whether it means anything without real-time scheduling.
    realtime: bool,
}

const fn at_most(name: &'static str, of: fn(&Value) -> Option<f64>, most: f64) -> Gate {
    Gate {
        name,
        of,
        least: 0.0,
        most,
        realtime: false,
    }
}

const fn realtime(gate: Gate) -> Gate {
    Gate {
        realtime: true,
        ..gate
    }
}

const fn exactly(name: &'static str, of: fn(&Value) -> Option<f64>, value: f64) -> Gate {
    Gate {
        least: value,
        ..at_most(name, of, value)
    }
}

/// What is held.
const GATES: &[Gate] = &[
    exactly(
        "allocations per tick",
        |f| f["allocs_per_tick"].as_f64(),
        1.0,
    ),
    exactly(
        "most allocations of a tick",
        |f| f["allocs_max"].as_f64(),
        1.0,
    ),
    exactly(
        "system calls per tick, the sleep",
        |f| f["syscalls_per_tick"].as_f64(),
        1.0,
    ),
    // Another compiler or C library moves it by some percent; less is welcome.
    at_most(
        "instructions per tick",
        |f| f["instructions_per_tick"].as_f64(),
        1.1 * INSTRUCTIONS,
    ),
    realtime(at_most(
        "page faults of all ticks",
        |f| f["daemon"]["page_faults"].as_f64(),
        0.0,
    )),
    // 0.99 to 1.03; 1.13 where the two cores are threads of one, so that the recorder's work slows the tick's.
    at_most(
        "tick body recording / not",
        |f| f["recording"]["body_ratio"].as_f64(),
        1.25,
    ),
    at_most(
        "sensor to command / (ping-pong + body)",
        |f| f["sensor_to_command_ratio"].as_f64(),
        3.0,
    ),
    at_most(
        "iceoryx2 / Unix socket",
        |f| {
            ratio(
                &f["transports_us"]["iceoryx2"],
                &f["transports_us"]["unix_socket"],
            )
        },
        1.0,
    ),
    at_most(
        "iceoryx2 / zenoh",
        |f| {
            ratio(
                &f["transports_us"]["iceoryx2"],
                &f["transports_us"]["zenoh"],
            )
        },
        0.5,
    ),
    // 0.01 and 0.05 on a quiet machine; with less sleep before the spin it would be 1.
    realtime(at_most(
        "wake p50 / cyclictest",
        |f| f["wake"]["p50_ratio"].as_f64(),
        0.05,
    )),
    realtime(at_most(
        "wake p50 / bare loop",
        |f| f["wake"]["idle"]["to_bare_loop"]["p50"].as_f64(),
        0.05,
    )),
    // A fifth is reached where both processes get their cores; a lost lock gives 1.
    realtime(at_most(
        "frame age p50 locked / p99 free",
        |f| {
            ratio(
                &f["frame_age_us"]["locked"]["p50"],
                &f["frame_age_us"]["free"]["p99"],
            )
        },
        0.34,
    )),
    realtime(at_most(
        "frame age p99 locked / free",
        |f| {
            ratio(
                &f["frame_age_us"]["locked"]["p99"],
                &f["frame_age_us"]["free"]["p99"],
            )
        },
        0.9,
    )),
    at_most(
        "resident memory, MiB",
        |f| f["daemon"]["resident_mib"].as_f64(),
        32.0,
    ),
];

fn ratio(of: &Value, to: &Value) -> Option<f64> {
    Some(of.as_f64()? / to.as_f64()?)
}

fn main() -> ExitCode {
    let figures = measure();
    println!("{figures:#}");
    keep(&figures);
    let is_realtime = figures["daemon"]["realtime"] == json!(true);
    let mut failed = 0;
    for gate in GATES {
        let value = (gate.of)(&figures);
        let verdict = match value {
            None => "not measured",
            Some(_) if gate.realtime && !is_realtime => "not held: no real-time scheduling here",
            Some(value) if (gate.least..=gate.most).contains(&value) => "holds",
            Some(_) => {
                failed += 1;
                "WORSE"
            }
        };
        let value = value.map_or("–".to_owned(), |value| format!("{value:.4}"));
        println!(
            "{:40} {value:>12} of {:<10} {verdict}",
            gate.name, gate.most
        );
    }
    if failed == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

fn measure() -> Value {
    let arguments = ["bench", "latency", "--short", "--format", "json"];
    let output = Command::new(binary("atas"))
        .args(arguments)
        .stderr(Stdio::inherit())
        .output()
        .expect("atas starts");
    assert!(output.status.success(), "atas bench latency failed");
    serde_json::from_slice(&output.stdout).expect("one JSON value")
}

/// Adds a line to the history.
fn keep(figures: &Value) {
    let atas = binary("atas");
    let target = atas.ancestors().nth(2).unwrap_or(Path::new("target"));
    let folder = target.join("bench");
    std::fs::create_dir_all(&folder).expect("the target folder is writable");
    let unix = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    let line = json!({
        "unix_s": unix.map_or(0, |time| time.as_secs()),
        "commit": commit(),
        "figures": figures,
    });
    let file = folder.join("latency.jsonl");
    let open = OpenOptions::new().create(true).append(true).open(&file);
    writeln!(open.expect("the history opens"), "{line}").expect("the history is writable");
    println!("kept in {}", file.display());
}

/// The commit that is checked out; "unknown" without git.
fn commit() -> String {
    let asked = Command::new("git").args(["rev-parse", "HEAD"]).output();
    let said = asked.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    said.ok()
        .filter(|text| !text.is_empty())
        .unwrap_or_else(|| "unknown".to_owned())
}
