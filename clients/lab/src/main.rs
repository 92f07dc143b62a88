//! `atas-lab`: laboratory commands of `atas`, those that need the controller or the simulator.
//!
//! ```text
//!  atas demo|eval|fault|soak|assure|plot|robot|explain|calibrate|bench|record|replay|diff|export ─▶ atas-lab
//!   ├─ demo ────▶ runs a robot team, or with atas-demo one robot, and evaluates the result
//!   ├─ eval ────▶ runs atas-evaluation on all cores
//!   ├─ fault ───▶ lists and injects faults with atas-faults
//!   ├─ soak ────▶ runs random tasks with random events with atas-faults
//!   ├─ assure ──▶ assesses the claims of atas-assurance and runs their evidence
//!   ├─ plot ────▶ draws recorded runs or an offline run
//!   ├─ robot ───▶ prints model, workspace and capabilities of a robot
//!   ├─ explain ─▶ explains the end of a goal, from a recording or a running daemon
//!   ├─ calibrate ▶ fits a sensor calibration to recorded presses
//!   ├─ bench ───▶ measures this machine, cyclictest and other transports
//!   ├─ record ──▶ records with atas-recording and a shadow controller
//!   ├─ record check|repair, diff, export ─▶ atas-recording
//!   └─ replay ──▶ runs the production controller on a recording
//! ```
//!
//! * **In:** the command line of `atas` ([`atas_console::arguments`]). **Out:** results, an exit
//!   code.
//! * **Invariants:** Ctrl-C ends every process and removes every bus that a command started.
//!   Numbers of `eval` and bytes of `plot` depend on the arguments only, not on the number of
//!   threads; measured times vary.
//! * **Not included:** commands for operation; they are in `atas`, which does not link this crate.

mod assure;
mod bench;
mod calibrate;
mod configuration;
mod demo;
mod eval;
mod explain;
mod fault;
mod picture;
mod plot;
mod record;
mod recordings;
mod replay;
mod robot;
mod soak;

use std::process::ExitCode;

use atas_console::arguments::{Command, RecordAction};
use atas_console::{Exit, ExitError, Interrupt, Output};

fn main() -> ExitCode {
    atas_console::run(execute)
}

fn execute(command: &Command, interrupt: &Interrupt, output: &mut Output) -> anyhow::Result<()> {
    match command {
        Command::Demo { task } => demo::demo(task, interrupt, output),
        Command::Eval { task } => eval::evaluate(task, interrupt, output),
        Command::Fault { action } => fault::fault(action, interrupt, output),
        Command::Soak(arguments) => soak::soak(arguments, interrupt, output),
        Command::Assure(arguments) => assure::assure(arguments, interrupt, output),
        Command::Plot { offline, recorded } => {
            plot::plot(offline.as_ref(), recorded.as_ref(), output)
        }
        Command::Explain(arguments) => explain::explain(arguments, output),
        Command::Bench { what } => bench::bench(what, interrupt, output),
        Command::Robot { action } => robot::robot(action, output),
        Command::Calibrate { action } => calibrate::calibrate(action, interrupt, output),
        Command::Record {
            action: None,
            options,
        } => record::record(options, interrupt, output),
        Command::Record {
            action: Some(RecordAction::Check { file }),
            ..
        } => recordings::check(file, output),
        Command::Record {
            action: Some(RecordAction::Repair { file, out }),
            ..
        } => recordings::repair(file, out.as_deref(), output),
        Command::Diff { first, second } => recordings::diff(first, second, output),
        Command::Export(arguments) => recordings::export(arguments, interrupt, output),
        Command::Replay { files } => replay::replay(files, output),
        _ => Err(ExitError::with_code(
            Exit::Usage,
            "this program runs the laboratory commands only; run `atas` instead",
        )),
    }
}
