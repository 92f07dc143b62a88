//! `atas-lab`: the laboratory's part of the `atas` command, which needs the controller or the simulator.
//!
//! ```text
//!  atas demo|eval|plot|robot|explain|calibrate|bench|record|replay ─▶ atas-lab
//!   ├─ demo ────▶ starts atasd and atas-sim on a fresh bus, sends the goal, judges by the truth
//!   ├─ eval ────▶ atas-evaluation on all cores
//!   ├─ plot ────▶ atas-evaluation, recorded runs or an offline run, as a figure
//!   ├─ robot ───▶ what a robot is, reaches and can do
//!   ├─ explain ─▶ why a goal ended as it did, from a recording or a running daemon, with a figure
//!   ├─ calibrate ▶ recorded presses into a calibration of a sensor
//!   ├─ bench ───▶ this machine, beside cyclictest and other transports
//!   ├─ record ──▶ atas-recording, with the controller beside it
//!   └─ replay ──▶ the production controller on a recording
//! ```
//!
//! * **In:** the command line that `atas` was given ([`atas_console::arguments`]). **Out:** results, an exit code.
//! * **Invariants:** Ctrl-C leaves neither a process nor a bus behind that a command started. The numbers of `eval` and the bytes
//!   of `plot` depend on its arguments only, not on the threads; times do.
//! * **Absent on purpose:** what an operator needs: that is `atas`, which links nothing of this.

mod bench;
mod calibrate;
mod demo;
mod eval;
mod explain;
mod picture;
mod plot;
mod record;
mod replay;
mod robot;

use std::process::ExitCode;

use atas_console::arguments::Command;
use atas_console::{Ended, Exit, Interrupt, Output};

fn main() -> ExitCode {
    atas_console::run(execute)
}

fn execute(command: &Command, interrupt: &Interrupt, output: &mut Output) -> anyhow::Result<()> {
    match command {
        Command::Demo { task } => demo::demo(task, interrupt, output),
        Command::Eval { task } => eval::evaluate(task, interrupt, output),
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
        Command::Replay { files } => replay::replay(files, output),
        _ => Err(Ended::with(
            Exit::Usage,
            "this is the laboratory's part of the command; ask `atas` for it",
        )),
    }
}
