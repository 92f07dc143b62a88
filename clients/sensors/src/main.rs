//! `atas-sensor`: reads real sensors, publishes what they feel. See `atas-sensor --help`.

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;

use atas_sensors::cli;
use atas_sensors::commands;
use tracing_subscriber::EnvFilter;

fn main() -> ExitCode {
    let matches = cli::command().get_matches();
    start_log();
    match commands::run(&matches) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // If nobody can read it, nobody needs to be told.
            let _ = writeln!(io::stderr(), "atas-sensor: {failure}");
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
