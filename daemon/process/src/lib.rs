//! Utilities shared by all ATAS processes: command line, logging, shutdown, real-time scheduling,
//! system configuration and kernel process state.
//!
//! ```text
//!  tracing ─▶ log ─▶ standard error
//!  SIGINT, SIGTERM ─▶ shutdown ─▶ a flag
//!  fatal_signals ─▶ standard error, record
//!  thread ─▶ scheduling ─▶ SCHED_FIFO
//! ```
//!
//! * **Invariants:** logging never blocks on its reader, and a closed standard error never causes a
//!   panic.
//! * **Not included:** the bus (`shm-bus`), and memory locking and core pinning, which only the
//!   daemon does (`atasd::realtime`).

pub mod command_line;
pub mod configuration;
pub mod exit;
pub mod fatal_signals;
pub mod file_name;
pub mod log;
pub mod scheduling;
pub mod shutdown;
pub mod stat;

use std::fmt::Display;
use std::io::{self, Write as _};
use std::process::ExitCode;

use exit::Exit;

/// Runs a process: starts the log, does the work, and prints the error and returns its exit code if
/// the work fails.
pub fn run<E: Display>(
    program: &str,
    work: impl FnOnce() -> Result<(), E>,
    exit_code: impl FnOnce(&E) -> Exit,
) -> ExitCode {
    // Every ATAS process needs threads, so this failure ends it.
    let log = match log::start(log::LogFormat::Human, log::LevelFilter::INFO) {
        Ok(log) => log,
        Err(error) => {
            let _ = writeln!(io::stderr(), "{program}: could not start a thread: {error}");
            return ExitCode::FAILURE;
        }
    };
    let outcome = work();
    drop(log);
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            let exit = exit_code(&failure);
            let as_json = command_line::json_requested();
            command_line::print_error(program, &failure.to_string(), exit, as_json);
            exit.into()
        }
    }
}

/// Tests of the programs in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
