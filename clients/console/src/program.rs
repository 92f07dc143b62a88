//! Main function of a program, from command line to exit code.

use std::process::ExitCode;

use atas_process::command_line;
use clap::FromArgMatches;

use crate::arguments::{Arguments, Command, command};
use crate::{Exit, Interrupt, Output, exit_of};

/// Program name in error messages, the same for all `atas` programs.
const PROGRAM: &str = "atas";

/// Parses the command line, runs the command with `execute`, prints an error on one line and
/// returns the exit code.
#[must_use]
pub fn run(
    execute: impl FnOnce(&Command, &Interrupt, &mut Output) -> anyhow::Result<()>,
) -> ExitCode {
    log_to_stderr();
    let parsed = command()
        .try_get_matches()
        .and_then(|matches| Arguments::from_arg_matches(&matches));
    let arguments = match parsed {
        Ok(arguments) => arguments,
        Err(error) => return command_line::exit_without_work(PROGRAM, &error),
    };
    let mut output = Output::new(arguments.format);
    let ended = Interrupt::install()
        .and_then(|interrupt| execute(&arguments.command, &interrupt, &mut output));
    let Err(error) = ended else {
        return Exit::Ok.into();
    };
    if is_broken_pipe(&error) {
        return Exit::Ok.into();
    }
    let exit = exit_of(&error);
    let sentence = format!("{error:#}");
    command_line::print_error(PROGRAM, &sentence, exit, output.is_json());
    exit.into()
}

/// Returns true if the reader of the output closed the pipe, as in `atas events | head`. This is
/// not an error.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let io = error.downcast_ref::<std::io::Error>();
    io.is_some_and(|io| io.kind() == std::io::ErrorKind::BrokenPipe)
}

/// Logs to standard error: warnings, or the levels of `RUST_LOG`.
fn log_to_stderr() {
    let filter = tracing_subscriber::EnvFilter::try_from_default_env()
        .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new("warn"));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_target(false)
        .init();
}
