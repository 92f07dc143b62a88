//! Runs `atas bench latency --short` and fails if a figure exceeds its bound.
//!
//! Bounds are ratios and counts, never microseconds. All figures are printed and appended, with the
//! machine, to `target/bench/latency.jsonl`, one line per run.
//!
//! `cargo bench -p system-tests --bench latency` after `cargo build --workspace`.
//!
//! Bounds and the handling of missing figures: `system_tests::gates`.

#![expect(
    clippy::print_stdout,
    reason = "figures are the product of a benchmark"
)]

use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::SystemTime;

use serde_json::{Value, json};
use system_tests::binary;
use system_tests::gates::{GATES, evaluate};

fn main() -> ExitCode {
    let figures = measure();
    println!("{figures:#}");
    append_history(&figures);
    match evaluate(GATES, &figures) {
        0 => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
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

/// Appends the figures as one line to the history file.
fn append_history(figures: &Value) {
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
    println!("appended to {}", file.display());
}

/// Returns the commit that is checked out, or "unknown" without git.
fn commit() -> String {
    let asked = Command::new("git").args(["rev-parse", "HEAD"]).output();
    let message = asked.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    message
        .ok()
        .filter(|text| !text.is_empty())
        .unwrap_or_else(|| "unknown".to_owned())
}
