//! `atas`: commands and queries of an operator to a running daemon.
//!
//! ```text
//!  atas_console::arguments ─▶ main ─┬─ --remote ──▶ `atas-remote`: the same command elsewhere
//!                                   ├─ atas_gate ──▶ the same command as the user of the bus
//!                                   ├─ goals ─▶ send ─▶ goal, followed to its end
//!                                   ├─ estop ──────▶ stop, over a separate channel
//!                                   ├─ status, topic, events, latency, control ─▶ queries
//!                                   ├─ doctor ─────▶ checks of the computer
//!                                   ├─ recordings ─▶ files of a folder
//!                                   └─ companions ─▶ `atas-demo`, `atas-lab`, `atas-live`, …
//! ```
//!
//! * **Inputs:** arguments, `ATAS_BUS`, `NO_COLOR`.
//! * **Outputs:** results on standard output, progress and errors on standard error, an exit code
//!   of [`atas_console::Exit`].
//! * **Invariants:** a request waits for the daemon's answer. Without a daemon it fails within one
//!   second with its own exit code. This program links neither the controller nor the simulator.
//! * **Not included:** control, perception and limits (daemon); commands that need a simulator
//!   (`atas-demo`, `atas-lab`), a full-screen terminal or a server (`atas-live`).

mod companions;
mod control;
mod doctor;
mod events;
mod goals;
mod latency;
mod manual;
mod recordings;
mod send;
mod status;
mod topic;

use std::process::ExitCode;

use atas_console::arguments::{self, BusArgument, Command, Param, Program};
use atas_console::{Interrupt, Output, estop};

fn main() -> ExitCode {
    atas_console::run_any(|arguments, interrupt, output| {
        if arguments.remote.remote.is_some() {
            return companions::exec_companion(Program::Remote);
        }
        let command = &arguments.command;
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
        Command::Estop(BusArgument { bus }) => estop::print_stopped(output, estop::stop(bus)?),
        Command::Cancel(bus) => control::cancel(&bus.bus, output),
        Command::Recover(bus) => control::recover(&bus.bus, output),
        Command::Zero(arguments) => control::zero(arguments, output),
        Command::Status(arguments) => status::status(arguments, interrupt, output),
        Command::Topic { action } => topic::topic(action, interrupt, output),
        Command::Events(arguments) => events::events(arguments, interrupt, output),
        Command::Param { action } => parameter(action, output),
        Command::Latency(arguments) => latency::latency(arguments, interrupt, output),
        Command::Doctor(arguments) => doctor::doctor(arguments, output),
        Command::Completions { shell } => {
            // Generates into memory first: clap's generator panics on a closed pipe or full disk.
            let (mut command, mut script) = (arguments::command(), Vec::new());
            clap_complete::generate(*shell, &mut command, "atas", &mut script);
            output.bytes(&script)
        }
        Command::Man { folder } => manual::write(folder),
        Command::Recordings { action } => recordings::recordings(action, output),
        Command::Demo { .. }
        | Command::Eval { .. }
        | Command::Fault { .. }
        | Command::Soak(_)
        | Command::Assure(_)
        | Command::Plot { .. }
        | Command::Bench { .. }
        | Command::Calibrate { .. }
        | Command::Robot { .. }
        | Command::Record { .. }
        | Command::Replay { .. }
        | Command::Diff { .. }
        | Command::Explain(_)
        | Command::Export(_)
        | Command::Teleop(_)
        | Command::Top(_)
        | Command::Dashboard(_)
        | Command::Remote { .. }
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
