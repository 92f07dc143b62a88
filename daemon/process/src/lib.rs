//! What the processes on a bus do alike, whatever they are: how they read a command line, how they log, how they end, how a thread
//! becomes real-time, where the system's configuration is, what the kernel says of them.
//!
//! ```text
//!  tracing ─▶ log ─▶ standard error        SIGINT, SIGTERM ─▶ end ─▶ a flag        thread ─▶ scheduling ─▶ SCHED_FIFO
//! ```
//!
//! * **Invariants:** nothing here waits for who reads the log, and nothing panics because standard error is gone.
//! * **Absent on purpose:** the bus (`shm-bus`), and what only the daemon does: locked memory, pinned cores
//!   (`atasd::realtime`).

pub mod command_line;
pub mod configuration;
pub mod end;
pub mod file_name;
pub mod log;
pub mod scheduling;
pub mod stat;

use std::fmt::Display;
use std::io::{self, Write as _};
use std::process::ExitCode;

/// The life of a process: a log, its work, and the sentence and exit code that its failure has.
pub fn run<E: Display>(
    program: &str,
    work: impl FnOnce() -> Result<(), E>,
    exit_code: impl FnOnce(&E) -> u8,
) -> ExitCode {
    // Without threads no process of ours can work.
    let log = match log::start(log::LogFormat::Human) {
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
            let as_json = command_line::wants_json();
            command_line::tell(program, &failure.to_string(), exit, as_json);
            ExitCode::from(exit)
        }
    }
}
