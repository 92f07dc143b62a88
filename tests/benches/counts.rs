//! Counts the costs of a million production ticks of a grasp: one allocation per tick, no page
//! faults, no system calls.
//!
//! Lock-step has no sleep. The running daemon makes one system call per tick, the sleep: see
//! `daemon/tests/daemon/kernel.rs` and `atas bench latency`.
//!
//! `cargo bench -p system-tests --bench counts -- [TICKS]`

#![expect(
    clippy::print_stdout,
    reason = "figures are the product of a benchmark"
)]

use std::io::ErrorKind;
use std::process::{Command, Output};

use serde_json::Value;
use system_tests::binary;

/// Default number of ticks.
const TICKS: &str = "1000000";
/// System call that `atas-bench` makes once before and once after the steady ticks.
const MARK: &str = "getppid(";

fn main() {
    let printed = std::env::args().skip(1).find(|a| a.parse::<u64>().is_ok());
    let ticks = printed.unwrap_or_else(|| TICKS.to_owned());
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
            let text = std::fs::read_to_string(&trace).expect("strace wrote its file");
            (output, Some(between_marks(&text)))
        }
        Err(error) if error.kind() != ErrorKind::NotFound => panic!("strace: {error}"),
        // strace is not installed or may not trace.
        _ => (run_untraced(&program, &ticks), None),
    };
    let figures: Value = serde_json::from_slice(&output.stdout).expect("one JSON value");
    println!("{figures}");
    assert_eq!(
        figures["allocations"], figures["ticks"],
        "one allocation per tick"
    );
    assert_eq!(figures["allocations_max"], 1);
    if figures["memory_locked"] == true {
        assert_eq!(figures["page_faults"], 0);
    } else {
        println!("page faults not checked: this machine does not let the process lock its memory");
    }
    match calls {
        Some(calls) => {
            println!("system calls during these ticks: {}", calls.len());
            assert!(calls.is_empty(), "{calls:?}");
        }
        None => println!("system calls not counted: strace is not installed or may not trace"),
    }
}

fn run_untraced(program: &std::path::Path, ticks: &str) -> Output {
    let output = Command::new(program).args(["run", ticks]).output();
    output.expect("atas-bench starts")
}

/// Returns the system calls between the two marks, of the thread that made the marks.
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
