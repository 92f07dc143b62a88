//! `atas`: what an operator says to a running daemon and asks of it.
//!
//! ```text
//!  atas_console::arguments ─▶ main ─┬─ atas_gate ─────────▶ the same command as another user, whose bus it is
//!                                   ├─ goals ─▶ send ────▶ a goal, followed to its end
//!                                   ├─ follow ──────────▶ a stream of targets, by keys or from a file
//!                                   ├─ estop ───────────▶ a stop, on a way of its own
//!                                   ├─ status, top, topic, events, latency, control ─▶ one question, or many
//!                                   ├─ doctor ──────────▶ can this machine hold the tick
//!                                   ├─ recordings ───────────▶ atas-recording
//!                                   └─ neighbours ──────▶ `atas-lab`: demo, eval, plot, robot, calibrate, bench, record, replay, explain; `atas-live`: dashboard, foxglove
//! ```
//!
//! * **In:** arguments, `ATAS_BUS`, `NO_COLOR`. **Out:** results on standard output, progress and errors on standard error, and
//!   an exit code of [`atas_console::Exit`].
//! * **Invariants:** a command that asks something of a daemon waits for its answer. Without a daemon it ends within one second,
//!   with a code of its own. What stops a robot links neither the controller nor the simulator.
//! * **Absent on purpose:** control, perception and limits (the daemon's); whatever needs a simulator (`atas-lab`).

mod control;
mod doctor;
mod estop;
mod events;
mod follow;
mod goals;
mod keys;
mod latency;
mod manual;
mod neighbours;
mod recordings;
mod refusals;
mod send;
mod status;
mod top;
mod topic;

use std::process::ExitCode;

use atas_console::arguments::{self, Command, Param, RecordAction};
use atas_console::{Interrupt, Output};

fn main() -> ExitCode {
    atas_console::run(|command, interrupt, output| {
        // Returns unless the bus is another user's.
        atas_gate::pass(command)?;
        execute(command, interrupt, output)
    })
}

/// The only place that knows which function a command is.
fn execute(command: &Command, interrupt: &Interrupt, output: &mut Output) -> anyhow::Result<()> {
    match command {
        Command::Grasp(arguments) => goals::grasp(arguments, interrupt, output),
        Command::PickPlace(arguments) => goals::pick_place(arguments, interrupt, output),
        Command::Screw(arguments) => goals::screw(arguments, interrupt, output),
        Command::Assemble(arguments) => goals::assemble(arguments, interrupt, output),
        Command::Task(arguments) => goals::task(arguments, interrupt, output),
        Command::Release(arguments) => goals::release(arguments, interrupt, output),
        Command::Follow(arguments) => follow::follow(arguments, interrupt, output),
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
            None => neighbours::hand_over(command.program()),
            Some(RecordAction::Check { file }) => recordings::check(file, output),
            Some(RecordAction::Repair { file, out }) => {
                recordings::repair(file, out.as_deref(), output)
            }
        },
        Command::Diff { first, second } => recordings::diff(first, second, output),
        Command::Export(arguments) => recordings::export(arguments, interrupt, output),
        Command::Doctor(bus) => doctor::doctor(&bus.bus, output),
        Command::Completions { shell } => {
            // Into memory first: clap's generator panics where a pipe is closed or a disk is full.
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
        | Command::Foxglove(_) => neighbours::hand_over(command.program()),
    }
}

fn parameter(action: &Param, output: &mut Output) -> anyhow::Result<()> {
    match action {
        Param::List(bus) => control::list(&bus.bus, output),
        Param::Get { name, bus } => control::get(&bus.bus, name, output),
        Param::Set { name, value, bus } => control::set(&bus.bus, name, *value, output),
    }
}
