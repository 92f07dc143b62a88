//! `atas-sensor`: reads real sensors, publishes what they feel. See `atas-sensor --help`.

use std::process::ExitCode;

use atas_sensors::{cli, commands, failure::Failure};

fn main() -> ExitCode {
    let matches = cli::command().get_matches();
    atas_process::run(
        "atas-sensor",
        || commands::run(&matches),
        Failure::exit_code,
    )
}
