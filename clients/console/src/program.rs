//! Main function of a program, from command line to exit code.

use std::process::ExitCode;

use atas_process::command_line;
use atas_process::log::{self, LevelFilter, LogFormat};
use clap::FromArgMatches;

use crate::arguments::{Arguments, Command, RemoteAction, command};
use crate::{Exit, ExitError, Interrupt, Output, exit_of};

/// Program name in error messages, the same for all `atas` programs.
const PROGRAM: &str = "atas";

/// Parses the command line, runs the command with `execute` on this machine, prints an error on one
/// line and returns the exit code.
#[must_use]
pub fn run(
    execute: impl FnOnce(&Command, &Interrupt, &mut Output) -> anyhow::Result<()>,
) -> ExitCode {
    run_any(|arguments, interrupt, output| {
        if arguments.remote.remote.is_some() {
            let sentence = "this program does not connect to other machines; run `atas --remote`";
            return Err(ExitError::with_code(Exit::Usage, sentence));
        }
        execute(&arguments.command, interrupt, output)
    })
}

/// As [`run`], for programs that also handle `--remote`.
#[must_use]
pub fn run_any(
    execute: impl FnOnce(&Arguments, &Interrupt, &mut Output) -> anyhow::Result<()>,
) -> ExitCode {
    let parsed = command()
        .try_get_matches()
        .and_then(|matches| Arguments::from_arg_matches(&matches));
    let arguments = match parsed {
        Ok(arguments) => arguments,
        Err(error) => return command_line::exit_without_work(PROGRAM, &error),
    };
    let level = match arguments.command {
        // A server reports each connection.
        Command::Remote {
            action: RemoteAction::Serve { .. },
        } => LevelFilter::INFO,
        _ => LevelFilter::WARN,
    };
    let log = match log::start(LogFormat::Human, level) {
        Ok(log) => log,
        Err(error) => {
            let sentence = format!("could not start the log: {error}; end other processes");
            command_line::print_error(PROGRAM, &sentence, Exit::Failed, false);
            return Exit::Failed.into();
        }
    };
    let mut output = Output::new(arguments.format);
    let ended =
        Interrupt::install().and_then(|interrupt| execute(&arguments, &interrupt, &mut output));
    let Err(error) = ended else {
        return Exit::Ok.into();
    };
    if is_broken_pipe(&error) {
        return Exit::Ok.into();
    }
    let exit = exit_of(&error);
    let sentence = format!("{error:#}");
    // The lines of the log come first.
    drop(log);
    command_line::print_error(PROGRAM, &sentence, exit, output.is_json());
    exit.into()
}

/// Returns true if the reader of the output closed the pipe, as in `atas events | head`. This is
/// not an error.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let io = error.downcast_ref::<std::io::Error>();
    io.is_some_and(|io| io.kind() == std::io::ErrorKind::BrokenPipe)
}
