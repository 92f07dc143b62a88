//! `atas-sim`: the simulated robot as a process on the bus. See `atas-sim --help`.
//!
//! Two ways to run: [`free_run`] follows the machine's clock at 1 kHz, [`lockstep`] waits for the daemon's answer to every
//! tick and so repeats bit for bit. Both drive the same [`session::Session`].
//! [`field_host`] is the other simulation: the swarm's field, at a frame rate or in lock-step with `ebts agents`.

mod args;
mod failure;
mod field_host;
mod free_run;
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
use sim_backend::faults::FaultKind;
use sim_backend::{Object, Scene, World};
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
        Command::Objects => list_objects(),
        Command::Faults => {
            list_faults();
            Ok(())
        }
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
    let robot = match &args.robot {
        Some(path) => RobotModel::from_urdf_file(path)?,
        None => RobotModel::two_hand_arm()?,
    };
    let scene = args.scene()?;
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
    tracing::info!(bus = %args.bus, seed = args.seed, pace, "simulating");
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

fn list_objects() -> Result<(), Failure> {
    let mut lines = vec![format!(
        "{:18} {:>7} {:>8} {:>8} {:>13} {:>8}",
        "name", "mass kg", "friction", "needed N", "stiffness N/m", "crush N"
    )];
    for name in Object::names().chain(Object::part_names()) {
        let object = Object::built_in(name)?;
        let (mass_kg, friction, needed_n) = (object.mass_kg, object.friction, object.needed_n());
        let or_none = |value: f64| {
            if value.is_finite() {
                value.to_string()
            } else {
                "-".to_owned()
            }
        };
        let (stiffness, crush) = (or_none(object.stiffness_n_m), or_none(object.crush_n));
        lines.push(format!(
            "{name:18} {mass_kg:7} {friction:8} {needed_n:8.2} {stiffness:>13} {crush:>8}"
        ));
    }
    print(&lines);
    Ok(())
}

fn list_faults() {
    let mut lines = vec![
        "KIND[=VALUE]@START[+LENGTH][:TARGET], times in seconds, for example drop=0.3@2+0.5:right"
            .to_owned(),
        format!(
            "{:10} {:>7}  {:26}  what happens",
            "kind", "usually", "targets"
        ),
    ];
    for fault in FaultKind::all() {
        let takes_value = fault.range != [0.0, 0.0];
        let usually = if takes_value {
            format!("{:?}", fault.value)
        } else {
            String::new()
        };
        lines.push(format!(
            "{:10} {usually:>7}  {:26}  {}",
            fault.name,
            fault.targets(),
            fault.about
        ));
    }
    print(&lines);
}

/// Writes lines to standard output. A reader that has seen enough closes it; that is no failure.
fn print(lines: &[String]) {
    let mut stdout = io::stdout().lock();
    let _ = lines.iter().try_for_each(|line| writeln!(stdout, "{line}"));
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
