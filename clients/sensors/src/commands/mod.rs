//! Subcommands.

mod listen;
mod manual;
mod probe;
mod read;
mod replay;

use std::io::{self, ErrorKind, Write};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use atas_process::shutdown;
use clap::{ArgMatches, FromArgMatches};
use serde_json::{Value, json};

use crate::cli::{Format, Tool};
use crate::failure::Failure;
use crate::plan::Plan;
use crate::wire::{SENSORS, named};

/// Executes the command line. A closed pipe (`atas-sensor list | head -1`) is not a failure.
///
/// # Errors
/// Every [`Failure`].
pub fn run(matches: &ArgMatches) -> Result<(), Failure> {
    match dispatch(matches) {
        Err(Failure::Table(error)) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        ended => ended,
    }
}

fn dispatch(matches: &ArgMatches) -> Result<(), Failure> {
    if let Some((name, arguments)) = matches.subcommand()
        && let Some(sensor) = named(name)
    {
        return read::run(Plan::from_sensor(sensor, arguments)?);
    }
    let tool = Tool::from_arg_matches(matches).map_err(|e| Failure::Usage(e.to_string()))?;
    match tool {
        Tool::Hand { file } => read::run(Plan::from_file(&file)?),
        Tool::List { format } => list(format),
        Tool::Probe { device, format } => probe::run(&device, format),
        Tool::Hz { bus_args, seconds } => listen::hz(&bus_args, seconds),
        Tool::Echo { bus_args, frames } => listen::echo(&bus_args, frames),
        Tool::Replay(arguments) => replay::run(arguments),
        Tool::Completions { shell } => manual::completions(shell),
        Tool::Man { folder } => manual::pages(&folder),
    }
}

fn list(format: Format) -> Result<(), Failure> {
    if format == Format::Json {
        let sensors: Vec<Value> = SENSORS
            .iter()
            .map(|sensor| {
                json!({
                    "name": sensor.name,
                    "about": sensor.about,
                    "wire": sensor.wire,
                    "taxels": sensor.taxels,
                    "rate_hz": sensor.rate_hz.parse::<u32>().ok(),
                })
            })
            .collect();
        return print(&json!({ "sensors": sensors }).to_string());
    }
    for sensor in SENSORS {
        print(&format!("{:<12} {}", sensor.name, sensor.about))?;
        print(&format!(
            "{:<12}   {} taxel{}, {} Hz, {}",
            "",
            sensor.taxels,
            if sensor.taxels == 1 { "" } else { "s" },
            sensor.rate_hz,
            sensor.wire
        ))?;
    }
    Ok(())
}

fn print(line: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    writeln!(out, "{line}")
        .and_then(|()| out.flush())
        .map_err(Failure::Table)
}

/// Returns a flag that SIGINT and SIGTERM set.
fn stop_on_signal() -> Result<Arc<AtomicBool>, Failure> {
    shutdown::install_stop_flag(&shutdown::SIGNALS, shutdown::IMMEDIATE_EXIT)
        .map_err(|error| Failure::Usage(format!("could not install the signal handlers: {error}")))
}
