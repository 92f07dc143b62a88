//! `atas-sensor`: reads real tactile sensors and publishes their frames. See `atas-sensor --help`.

use std::process::ExitCode;

use atas_process::command_line;
use atas_sensors::{cli, commands, failure::Failure};

const PROGRAM: &str = "atas-sensor";

fn main() -> ExitCode {
    match cli::command().try_get_matches() {
        Ok(matches) => atas_process::run(PROGRAM, || commands::run(&matches), Failure::exit_code),
        Err(error) => command_line::exit_without_work(PROGRAM, &error),
    }
}
