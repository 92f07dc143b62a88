//! `atas`: commands and queries of an operator to a running daemon.
//!
//! ```text
//!  atas_console::arguments ─▶ main ─┬─ atas_gate ──▶ the same command as the user of the bus
//!                                   ├─ goals ─▶ send ─▶ goal, followed to its end
//!                                   ├─ teleop ─────▶ stream of targets, from keyboard or file
//!                                   ├─ estop ──────▶ stop, over a separate channel
//!                                   ├─ status, top, topic, events, latency, control ─▶ queries
//!                                   ├─ doctor ─────▶ checks of the computer
//!                                   ├─ recordings ─▶ atas-recording
//!                                   └─ companions ─▶ `atas-lab`, `atas-live`
//! ```
//!
//! * **Inputs:** arguments, `ATAS_BUS`, `NO_COLOR`.
//! * **Outputs:** results on standard output, progress and errors on standard error, an exit code
//!   of [`atas_console::Exit`].
//! * **Invariants:** a request waits for the daemon's answer. Without a daemon it fails within one
//!   second with its own exit code. This program links neither the controller nor the simulator.
//! * **Not included:** control, perception and limits (daemon); commands that need a simulator
//!   (`atas-lab`).

mod companions;
mod control;
mod doctor;
mod estop;
mod events;
mod goals;
mod keys;
mod latency;
mod manual;
mod recordings;
mod rejections;
mod send;
mod status;
mod teleop;
mod top;
mod topic;

use std::process::ExitCode;

use atas_console::arguments::{self, Command, Param, RecordAction};
use atas_console::{Interrupt, Output};

fn main() -> ExitCode {
    atas_console::run(|command, interrupt, output| {
        // Returns unless the bus belongs to another user.
        atas_gate::run_through_gate(command)?;
        execute(command, interrupt, output)
    })
}

fn execute(command: &Command, interrupt: &Interrupt, output: &mut Output) -> anyhow::Result<()> {
    match command {
        Command::Grasp(arguments) => goals::grasp(arguments, interrupt, output),
        Command::PickPlace(arguments) => goals::pick_place(arguments, interrupt, output),
        Command::Screw(arguments) => goals::screw(arguments, interrupt, output),
        Command::Assemble(arguments) => goals::assemble(arguments, interrupt, output),
        Command::Task(arguments) => goals::task(arguments, interrupt, output),
        Command::Release(arguments) => goals::release(arguments, interrupt, output),
        Command::Teleop(arguments) => teleop::teleop(arguments, interrupt, output),
        Command::Estop(bus) => estop::estop(&bus.bus, output),
        Command::Cancel(bus) => control::cancel(&bus.bus, output),
        Command::Recover(bus) => control::recover(&bus.bus, output),
        Command::Zero(arguments) => control::zero(arguments, output),
        Command::Status(arguments) => status::status(arguments, interrupt, output),
        Command::Top(bus) => top::top(bus, interrupt),
        Command::Topic { action } => topic::topic(action, interrupt, output),
        Command::Events(arguments) => events::events(arguments, interrupt, output),
        Command::Param { action } => parameter(action, output),
        Command::Latency(arguments) => latency::latency(arguments, interrupt, output),
        Command::Record { action, .. } => match action {
            None => companions::exec_companion(command.program()),
            Some(RecordAction::Check { file }) => recordings::check(file, output),
            Some(RecordAction::Repair { file, out }) => {
                recordings::repair(file, out.as_deref(), output)
            }
        },
        Command::Diff { first, second } => recordings::diff(first, second, output),
        Command::Export(arguments) => recordings::export(arguments, interrupt, output),
        Command::Doctor(bus) => doctor::doctor(&bus.bus, output),
        Command::Completions { shell } => {
            // Generates into memory first: clap's generator panics on a closed pipe or full disk.
            let (mut command, mut script) = (arguments::command(), Vec::new());
            clap_complete::generate(*shell, &mut command, "atas", &mut script);
            output.bytes(&script)
        }
        Command::Man { folder } => manual::write(folder),
        Command::Demo { .. }
        | Command::Eval { .. }
        | Command::Plot { .. }
        | Command::Bench { .. }
        | Command::Calibrate { .. }
        | Command::Robot { .. }
        | Command::Replay { .. }
        | Command::Explain(_)
        | Command::Dashboard(_)
        | Command::Foxglove(_) => companions::exec_companion(command.program()),
    }
}

fn parameter(action: &Param, output: &mut Output) -> anyhow::Result<()> {
    match action {
        Param::List(bus) => control::list(&bus.bus, output),
        Param::Get { name, bus } => control::get(&bus.bus, name, output),
        Param::Set { name, value, bus } => control::set(&bus.bus, name, *value, output),
    }
}
