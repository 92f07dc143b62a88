//! What each subcommand does.

mod calibrate;
mod drive;
mod emulate;
mod hz;
mod manual;
mod probe;

use std::io::{self, ErrorKind, Write};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use atas_process::end;
use serde_json::json;

use crate::cli::{Format, Verb};
use crate::drivers::{DRIVERS, LimitKind};
use crate::failure::Failure;

/// Does what was said. A reader that has seen enough, as in `atas-robot list | head -1`, ends it in order.
///
/// # Errors
/// Everything that [`Failure`] names.
pub fn run(verb: Verb) -> Result<(), Failure> {
    match obey(verb) {
        Err(Failure::Output(error)) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        ended => ended,
    }
}

fn obey(verb: Verb) -> Result<(), Failure> {
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
        Verb::Emulate { map, out, format } => emulate::run(&map, &out, format),
        Verb::Completions { shell } => manual::completions(shell),
        Verb::Man { folder } => manual::pages(&folder),
    }
}

/// By what a model is limited, as the map's key says.
fn limited_by(kind: LimitKind) -> (&'static str, &'static str) {
    match kind {
        LimitKind::Current => ("current_limit_a", "A"),
        LimitKind::Torque => ("torque_limit_percent", "%"),
    }
}

/// The list of families and models.
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

/// One line on standard output.
fn print(line: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    writeln!(out, "{line}")
        .and_then(|()| out.flush())
        .map_err(Failure::Output)
}

/// One line for a person, beside what programs read.
fn say(line: &str) {
    // If nobody can read it, nobody needs to be told.
    let _ = writeln!(io::stderr(), "{line}");
}

/// Set when SIGINT or SIGTERM comes.
fn stop_on_signal() -> Result<Arc<AtomicBool>, Failure> {
    end::on_signals(&end::SIGNALS, end::AT_ONCE)
        .map_err(|error| Failure::Usage(format!("could not watch for signals: {error}")))
}

/// Writes a file for a person to use.
fn write(path: &std::path::Path, text: &str) -> Result<(), Failure> {
    std::fs::write(path, text)
        .map_err(|error| Failure::Usage(format!("could not write {}: {error}", path.display())))
}
