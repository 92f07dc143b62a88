//! Subcommands of `atas-robot`.

mod calibrate;
mod drive;
mod emulate;
mod hz;
mod manual;
mod probe;

use std::io::{self, ErrorKind, Write};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use atas_process::shutdown;
use serde_json::json;

use crate::cli::{Format, Verb};
use crate::drivers::{DRIVERS, LimitKind};
use crate::failure::Failure;

/// Runs a subcommand. A closed output pipe, as in `atas-robot list | head -1`, is no failure.
///
/// # Errors
/// See [`Failure`].
pub fn run(verb: Verb) -> Result<(), Failure> {
    match execute(verb) {
        Err(Failure::Output(error)) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        ended => ended,
    }
}

fn execute(verb: Verb) -> Result<(), Failure> {
    match verb {
        Verb::Run { map, bus, wait } => drive::run(&map, &bus, wait),
        Verb::List { format } => list(format),
        Verb::Probe {
            device,
            baud,
            format,
        } => probe::run(&device, baud, format),
        Verb::Hz {
            bus,
            seconds,
            format,
        } => hz::run(&bus, seconds, format),
        Verb::Calibrate { which, out } => calibrate::run(&which, out.as_deref()),
        Verb::Relax { which, yes } => calibrate::relax(&which, yes),
        Verb::Emulate {
            map,
            out,
            rest,
            format,
        } => emulate::run(&map, &out, rest, format),
        Verb::Completions { shell } => manual::completions(shell),
        Verb::Man { folder } => manual::pages(&folder),
    }
}

/// Returns map key and unit of a model's force limit.
fn limited_by(kind: LimitKind) -> (&'static str, &'static str) {
    match kind {
        LimitKind::Current => ("current_limit_a", "A"),
        LimitKind::Torque => ("torque_limit_percent", "%"),
    }
}

/// Prints the families and models.
fn list(format: Format) -> Result<(), Failure> {
    if format == Format::Json {
        let drivers = DRIVERS.map(|driver| {
            let models = driver.models().iter().map(|model| {
                json!({
                    "name": model.name,
                    "number": model.number,
                    "limited_by": limited_by(model.limit).0,
                    "limit_max": model.limit_max,
                })
            });
            json!({
                "name": driver.name(),
                "about": driver.about(),
                "bauds": driver.bauds(),
                "models": models.collect::<Vec<_>>(),
            })
        });
        return print(&json!({ "drivers": drivers }).to_string());
    }
    for driver in DRIVERS {
        print(&format!("{:<12} {}", driver.name(), driver.about()))?;
        for model in driver.models() {
            let (key, unit) = limited_by(model.limit);
            print(&format!(
                "{:<12}   {:<12} {key} up to {} {unit}",
                "", model.name, model.limit_max
            ))?;
        }
    }
    Ok(())
}

/// Prints a line on standard output.
fn print(line: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    writeln!(out, "{line}")
        .and_then(|()| out.flush())
        .map_err(Failure::Output)
}

/// Prints a message for users on standard error.
fn print_message(line: &str) {
    // A failed write is ignored: without standard error there is no reader.
    let _ = writeln!(io::stderr(), "{line}");
}

/// Returns a flag that SIGINT and SIGTERM set.
fn stop_on_signal() -> Result<Arc<AtomicBool>, Failure> {
    shutdown::install_stop_flag(&shutdown::SIGNALS, shutdown::IMMEDIATE_EXIT)
        .map_err(|error| Failure::Usage(format!("could not install the signal handler: {error}")))
}

/// Writes a text file.
fn write(path: &std::path::Path, text: &str) -> Result<(), Failure> {
    std::fs::write(path, text)
        .map_err(|error| Failure::Usage(format!("could not write {}: {error}", path.display())))
}
