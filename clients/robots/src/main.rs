//! `atas-robot`: drives real servos. See `atas-robot --help`.

use std::process::ExitCode;

use atas_process::command_line;
use atas_robots::{cli::Arguments, commands, failure::Failure};
use clap::Parser;

const PROGRAM: &str = "atas-robot";

fn main() -> ExitCode {
    match Arguments::try_parse() {
        Ok(Arguments { verb }) => {
            atas_process::run(PROGRAM, || commands::run(verb), Failure::exit_code)
        }
        Err(error) => command_line::exit_without_work(PROGRAM, &error),
    }
}
