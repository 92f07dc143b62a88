//! `atas-robot`: drives real servos. See `atas-robot --help`.

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;

use atas_robots::{cli, commands};
use clap::Parser;
use tracing_subscriber::EnvFilter;

fn main() -> ExitCode {
    let arguments = cli::Arguments::parse();
    start_log();
    match commands::run(arguments.verb) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // If nobody can read it, nobody needs to be told.
            let _ = writeln!(io::stderr(), "atas-robot: {failure}");
            ExitCode::from(failure.exit_code())
        }
    }
}

fn start_log() {
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("info"));
    let colours = io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(io::stderr)
        .with_ansi(colours)
        .init();
}
