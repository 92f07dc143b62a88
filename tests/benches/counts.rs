//! A million production ticks of a grasp: one allocation each, no page fault, no system call (in lock-step there is no
//! sleep either; the running daemon's one call per tick, the sleep, is counted by `daemon/tests/daemon/kernel.rs` and
//! `atas bench latency`).
//!
//! `cargo bench -p system-tests --bench counts -- [TICKS]`

#![expect(clippy::print_stdout, reason = "figures are the product of a bench")]

use std::io::ErrorKind;
use std::process::{Command, Output};

use serde_json::Value;
use system_tests::binary;

/// Ticks, unless told otherwise.
const TICKS: &str = "1000000";
/// What the program asks once when the steady ticks begin, and once when they end.
const MARK: &str = "getppid(";

fn main() {
    let told = std::env::args().skip(1).find(|a| a.parse::<u64>().is_ok());
    let ticks = told.unwrap_or_else(|| TICKS.to_owned());
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    let trace = folder.path().join("trace");
    let program = binary("atas-bench");
    let traced = Command::new("strace")
        .args(["-f", "-qq", "-o"])
        .arg(&trace)
        .arg(&program)
        .args(["run", &ticks])
        .output();
    let (output, calls) = match traced {
        Ok(output) if output.status.success() => {
            let text = std::fs::read_to_string(&trace).expect("strace wrote");
            (output, Some(between_marks(&text)))
        }
        Err(error) if error.kind() != ErrorKind::NotFound => panic!("strace: {error}"),
        // Not installed, or not allowed to trace.
        _ => (plain(&program, &ticks), None),
    };
    let figures: Value = serde_json::from_slice(&output.stdout).expect("one JSON value");
    println!("{figures}");
    assert_eq!(figures["allocations"], figures["ticks"], "one each");
    assert_eq!(figures["allocations_max"], 1);
    if figures["memory_locked"] == true {
        assert_eq!(figures["page_faults"], 0);
    } else {
        println!("page faults not held: memory may not be locked here");
    }
    match calls {
        Some(calls) => {
            println!("system calls in all of these ticks: {}", calls.len());
            assert!(calls.is_empty(), "{calls:?}");
        }
        None => println!("system calls not counted: strace is not installed, or may not trace"),
    }
}

fn plain(program: &std::path::Path, ticks: &str) -> Output {
    let output = Command::new(program).args(["run", ticks]).output();
    output.expect("atas-bench runs")
}

/// System calls of the thread that made the marks, between them.
fn between_marks(trace: &str) -> Vec<String> {
    let mut marks = trace.lines().filter(|line| line.contains(MARK));
    let thread = marks.next().and_then(|line| line.split(' ').next());
    let thread = thread.expect("the first mark");
    assert!(marks.next().is_some(), "the second mark");
    let own = trace.lines().filter(|line| line.starts_with(thread));
    own.skip_while(|line| !line.contains(MARK))
        .skip(1)
        .take_while(|line| !line.contains(MARK))
        .map(str::to_owned)
        .collect()
}
