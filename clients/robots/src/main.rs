//! `atas-robot`: drives real servos. See `atas-robot --help`.

use std::process::ExitCode;

use atas_robots::{cli, commands, failure::Failure};
use clap::Parser;

fn main() -> ExitCode {
    let arguments = cli::Arguments::parse();
    atas_process::run(
        "atas-robot",
        || commands::run(arguments.verb),
        Failure::exit_code,
    )
}
