//! A program from its command line to its exit code.

use std::io::Write;
use std::process::ExitCode;

use clap::FromArgMatches;
use serde_json::json;

use crate::arguments::{Arguments, Command, command};
use crate::{Exit, Format, Interrupt, Output};

/// Reads the command line, does what it says by `execute`, tells errors in one line, returns the exit code.
#[must_use]
pub fn run(
    execute: impl FnOnce(&Command, &Interrupt, &mut Output) -> anyhow::Result<()>,
) -> ExitCode {
    log_to_stderr();
    let arguments = match parse() {
        Ok(arguments) => arguments,
        Err(code) => return code,
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
    tell(arguments.format, &format!("{error:#}"), exit);
    exit.into()
}

/// The command line, or the end that it leads to by itself: help, a version, or wrong usage.
fn parse() -> Result<Arguments, ExitCode> {
    let parsed = command()
        .try_get_matches()
        .and_then(|matches| Arguments::from_arg_matches(&matches));
    parsed.map_err(|error| {
        if !error.use_stderr() {
            // A reader that goes away has read enough of a help.
            let _ = error.print();
            return Exit::Ok.into();
        }
        if wants_json() {
            let text = error.render().to_string();
            let sentence = text.trim_start_matches("error: ").trim_end();
            tell(Format::Json, sentence, Exit::Usage);
        } else {
            let _ = error.print();
        }
        Exit::Usage.into()
    })
}

/// Whether the user asked for JSON on a command line that is wrong elsewhere.
fn wants_json() -> bool {
    let words: Vec<String> = std::env::args().collect();
    let apart = words.windows(2).any(|pair| pair == ["--format", "json"]);
    apart || words.iter().any(|word| word == "--format=json")
}

/// Tells an error in one line. Nothing can be done if standard error is closed as well.
fn tell(format: Format, sentence: &str, exit: Exit) {
    let line = match format {
        Format::Human => format!("atas: {sentence}"),
        Format::Json => json!({ "error": sentence, "exit": exit as u8 }).to_string(),
    };
    let _ = writeln!(std::io::stderr(), "{line}");
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
