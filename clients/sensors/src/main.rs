//! `atas-sensor`: reads a real sensor, publishes what it feels. See `atas-sensor --help`.

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use atas_sensors::cli::{Cli, OptoforceArgs, Resolved, Sensor};
use atas_sensors::driver;
use atas_sensors::failure::Failure;
use atas_sensors::output::Output;
use atas_sensors::output::bus::Bus;
use atas_sensors::output::table::Table;
use clap::Parser;
use signal_hook::consts::{SIGINT, SIGTERM};
use tracing_subscriber::EnvFilter;

fn main() -> ExitCode {
    let cli = Cli::parse();
    start_log();
    let outcome = match cli.sensor {
        Sensor::Optoforce(args) => optoforce(args),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            say(&format!("atas-sensor: {failure}"));
            ExitCode::from(failure.exit_code())
        }
    }
}

fn optoforce(args: OptoforceArgs) -> Result<(), Failure> {
    let Resolved {
        settings,
        mapping,
        place,
    } = args.resolve()?;
    let stop = stop_on_signal()?;
    let device = settings.device.display().to_string();
    let mut output: Box<dyn Output> = match place {
        Some(place) => Box::new(Bus::open(place, settings.kind, &device)?),
        None => Box::new(Table::new(io::stdout(), settings.kind, mapping)?),
    };
    let (health, outcome) = driver::run(&settings, output.as_mut(), shm_bus::now_ns, &stop);
    say(&format!("optoforce {device}: {health}"));
    outcome
}

fn stop_on_signal() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop)).map_err(|error| {
            Failure::Usage(format!("could not watch for signal {signal}: {error}"))
        })?;
    }
    Ok(stop)
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

/// One line for people on standard error. If nobody can read it, nobody needs to be told.
fn say(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}
