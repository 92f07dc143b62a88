//! A program from its command line to its exit code.

use std::process::ExitCode;

use atas_process::command_line;
use clap::FromArgMatches;

use crate::arguments::{Arguments, Command, command};
use crate::{Exit, Interrupt, Output};

/// What errors are told under: all programs of this command line are one to their users.
const PROGRAM: &str = "atas";

/// Reads the command line, does what it says by `execute`, tells errors in one line, returns the exit code.
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
        Err(error) => return command_line::end(PROGRAM, &error, Exit::Failed as u8),
    };
    let mut output = Output::new(arguments.format);
    let ended = Interrupt::listen()
        .and_then(|interrupt| execute(&arguments.command, &interrupt, &mut output));
    let Err(error) = ended else {
        return Exit::Ok.into();
    };
    if is_broken_pipe(&error) {
        return Exit::Ok.into();
    }
    let exit = Exit::of(&error);
    let sentence = format!("{error:#}");
    command_line::tell(PROGRAM, &sentence, exit as u8, output.is_json());
    exit.into()
}

/// Whoever reads the output may stop reading: `atas events | head` is no error.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let io = error.downcast_ref::<std::io::Error>();
    io.is_some_and(|io| io.kind() == std::io::ErrorKind::BrokenPipe)
}

/// Warnings of the libraries below, or what `RUST_LOG` asks for.
fn log_to_stderr() {
    let filter = tracing_subscriber::EnvFilter::try_from_default_env()
        .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new("warn"));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_target(false)
        .init();
}
