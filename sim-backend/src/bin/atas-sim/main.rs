//! `atas-sim`: the simulated robot as a process on the bus. See `atas-sim --help`.
//!
//! Two ways to run: [`free_run`] follows the machine's clock at 1 kHz, [`lockstep`] waits for the daemon's answer to every
//! tick and so repeats bit for bit. Both drive the same [`session::Session`].
//! [`field_host`] is the other simulation: the swarm's field, at a frame rate or in lock-step with `ebts agents`.

mod args;
mod failure;
mod field_host;
mod free_run;
mod lists;
mod lockstep;
mod realtime;
mod scene_args;
mod session;
mod wait;

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Parser;
use robot_model::RobotModel;
use shm_bus::Bus;
use sim_backend::{Scene, World};
use tracing_subscriber::EnvFilter;

use args::{Cli, Command, RunArgs};
use failure::Failure;
use session::Session;

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Run(args) => {
            start_log();
            run(&args)
        }
        Command::Field(args) => {
            start_log();
            field_host::run(&args)
        }
        Command::Objects { format } => lists::objects(format),
        Command::Faults => lists::faults(),
        Command::Errors => lists::errors(),
        Command::Completions { shell } => lists::completions(shell),
        Command::Man { folder } => lists::manual(&folder),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // If nobody can read it, nobody needs to be told.
            let _ = writeln!(io::stderr(), "atas-sim: {failure}");
            ExitCode::from(failure.exit_code())
        }
    }
}

fn run(args: &RunArgs) -> Result<(), Failure> {
    let stop = stop_on_signal()?;
    let robot = RobotModel::find(&args.robot)?;
    let scene = args.scene(&robot)?;
    let world = World::new(&robot, &scene, args.seed)?;
    let bus = Bus::open(&args.bus, "atas-sim", shm_bus::Realtime::Yes)?;
    let mut session = Session::open(&bus, world, &args.faults, args.seed)?;
    announce(args, &scene);
    let outcome = if args.lockstep {
        lockstep::run(&mut session, args.duration, &stop)
    } else {
        free_run::run(&mut session, args.duration, &stop)
    };
    session.report();
    outcome
}

/// Says what is simulated, and where a client would grasp it.
fn announce(args: &RunArgs, scene: &Scene) {
    let pace = if args.lockstep { "lock-step" } else { "1 kHz" };
    tracing::info!(bus = %args.bus, robot = args.robot, seed = args.seed, pace, "simulating");
    for (index, placed) in scene.objects.iter().enumerate() {
        if let Some(hint) = scene.grasp_hint(index) {
            let [x, y, z] = hint.from_m;
            tracing::info!(
                object = placed.object.name,
                from_m = format!("{x:.3},{y:.3},{z:.3}"),
                yaw_deg = format!("{:.0}", hint.yaw_rad.to_degrees()),
                width_m = hint.width_m,
                "on the table"
            );
        }
    }
    if let Some(place) = scene.place {
        let [x, y, z] = place.from_m;
        tracing::info!(to_m = format!("{x:.3},{y:.3},{z:.3}"), "its place");
    }
}

fn stop_on_signal() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop)).map_err(Failure::Signals)?;
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
        // What cannot be logged cannot be complained of there either.
        .log_internal_errors(false)
        .init();
}
