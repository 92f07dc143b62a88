//! `atas-sim`: the simulators as a process on the bus. See `atas-sim --help`.
//!
//! * [`free_run`] simulates a robot in real time at 1 kHz. [`lockstep`] waits for the daemon's
//!   response to every tick, so runs are bit-identical. Both use [`session::Session`].
//! * [`course_host`] simulates robots on wheeled bases, in lock-step with their daemons,
//!   coordinators and tables.
//! * [`field_host`] simulates the swarm's field, at a frame rate or in lock-step with
//!   `ebts agents`.

mod args;
mod course_host;
mod failure;
mod field_host;
mod free_run;
mod lists;
mod lockstep;
mod output;
mod scene_args;
mod session;
mod wait;

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use atas_process::{command_line, shutdown};
use clap::Parser;
use robot_model::RobotModel;
use shm_bus::Bus;
use sim_backend::engine::EngineProcess;
use sim_backend::{Scene, World};

use args::{Cli, Command, RunArgs};
use failure::Failure;
use session::Session;

const PROGRAM: &str = "atas-sim";

fn main() -> ExitCode {
    match Cli::try_parse() {
        Ok(Cli { command }) => atas_process::run(PROGRAM, || dispatch(command), Failure::exit_code),
        Err(error) => command_line::exit_without_work(PROGRAM, &error),
    }
}

fn dispatch(command: Command) -> Result<(), Failure> {
    match command {
        Command::Run(args) => run(&args),
        Command::Field(args) => field_host::run(&args),
        Command::Course(args) => course_host::run(&args),
        Command::Objects { format } => lists::objects(format),
        Command::Faults => lists::faults(),
        Command::Errors => lists::errors(),
        Command::Sensors { name, format } => lists::sensors(name.as_deref(), format),
        Command::Completions { shell } => lists::completions(shell),
        Command::Man { folder } => lists::manual(&folder),
    }
}

fn run(args: &RunArgs) -> Result<(), Failure> {
    let stop = stop_on_signal()?;
    let robot = RobotModel::find(&args.robot)?;
    let scene = args.scene(&robot)?;
    let world = match &args.engine {
        None => World::new(&robot, &scene, args.seed)?,
        Some(command) => {
            let engine = Box::new(EngineProcess::start(command)?);
            World::with_engine(&robot, &scene, args.seed, engine)?
        }
    };
    let bus = Bus::open(&args.bus, "atas-sim", shm_bus::Realtime::Yes)?;
    let mut session = Session::open(&bus, world, &args.faults, args.seed)?;
    log_scene(args, &robot, &scene);
    let outcome = if args.lockstep {
        lockstep::run(&mut session, args.duration, &stop)
    } else {
        free_run::run(&mut session, args.duration, &stop)
    };
    session.report();
    outcome
}

/// Logs the scene and an example client command.
fn log_scene(args: &RunArgs, robot: &RobotModel, scene: &Scene) {
    let pace = if args.lockstep { "lock-step" } else { "1 kHz" };
    let version = env!("CARGO_PKG_VERSION");
    tracing::info!(version, bus = %args.bus, robot = args.robot, seed = args.seed, pace, "simulating");
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
        tracing::info!(to_m = format!("{x:.3},{y:.3},{z:.3}"), "target position");
    }
    if let Some(command) = args.example_command(robot, scene) {
        tracing::info!("example client command: {command}");
    }
}

fn stop_on_signal() -> Result<Arc<AtomicBool>, Failure> {
    shutdown::install_stop_flag(&shutdown::SIGNALS, shutdown::IMMEDIATE_EXIT)
        .map_err(Failure::Signals)
}
