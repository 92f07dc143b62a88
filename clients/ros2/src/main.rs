//! `atas-ros2`: ROS 2 bridge. See `atas-ros2 --help`.

use std::io::Write as _;
use std::process::ExitCode;

use atas_process::exit::Exit;
use atas_process::{command_line, shutdown};
use atas_ros2::arguments::Arguments;
use atas_ros2::wire::catalogue;
use clap::Parser;

const PROGRAM: &str = "atas-ros2";

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => return command_line::exit_without_work(PROGRAM, &error),
    };
    atas_process::run(PROGRAM, || execute(&arguments), |_| Exit::Failed)
}

fn execute(arguments: &Arguments) -> Result<(), String> {
    if arguments.print_types {
        let lines = catalogue::entries().into_iter();
        let lines: Vec<String> = lines
            .map(|(name, hash)| format!("{name} {hash}\n"))
            .collect();
        let written = std::io::stdout().write_all(lines.concat().as_bytes());
        return written.map_err(|error| format!("could not print the types: {error}"));
    }
    // The middleware reports every peer on this level; RUST_LOG changes that.
    if std::env::var_os("RUST_LOG").is_none() {
        log::set_max_level(log::LevelFilter::Error);
    }
    let stop = shutdown::install_stop_flag(&shutdown::SIGNALS, shutdown::IMMEDIATE_EXIT)
        .map_err(|error| format!("could not install signal handlers: {error}"))?;
    atas_ros2::run(arguments, &stop).map_err(|error| format!("{error:#}"))
}
