//! What each subcommand does.

mod listen;
mod manual;
mod probe;
mod read;
mod replay;

use std::io::{self, ErrorKind, Write};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use atas_process::end;
use clap::{ArgMatches, FromArgMatches};
use serde_json::{Value, json};

use crate::cli::{Format, Tool};
use crate::failure::Failure;
use crate::plan::Plan;
use crate::wire::{SENSORS, named};

/// Does what was said. A reader that has seen enough, as in `atas-sensor list | head -1`, ends it in order.
///
/// # Errors
/// Everything that [`Failure`] names.
pub fn run(matches: &ArgMatches) -> Result<(), Failure> {
    match obey(matches) {
        Err(Failure::Table(error)) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        ended => ended,
    }
}

fn obey(matches: &ArgMatches) -> Result<(), Failure> {
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
        Tool::Hz { at, seconds } => listen::hz(&at, seconds),
        Tool::Echo { at, frames } => listen::echo(&at, frames),
        Tool::Replay(arguments) => replay::run(arguments),
        Tool::Completions { shell } => manual::completions(shell),
        Tool::Man { folder } => manual::pages(&folder),
    }
}

/// The list of sensors.
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

/// One line on standard output.
fn print(line: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    writeln!(out, "{line}")
        .and_then(|()| out.flush())
        .map_err(Failure::Table)
}

/// Set when SIGINT or SIGTERM comes.
fn stop_on_signal() -> Result<Arc<AtomicBool>, Failure> {
    end::on_signals(&end::SIGNALS, end::AT_ONCE)
        .map_err(|error| Failure::Usage(format!("could not watch for signals: {error}")))
}
