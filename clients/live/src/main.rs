//! `atas-live`: observation in a browser or in Foxglove.
//!
//! ```text
//!  bus ─▶ observe (a thread) ─▶ Feed ─▶ server ─▶ page    live: pictures, events, faults
//!  recording ─▶ shelf ────────────────▶ server ─▶ page    recorded: the same pictures, by number
//!  bus ─▶ foxglove ─▶ ROS 2 messages over a WebSocket     live, for custom layouts
//!  page ─▶ server ─ guard ─▶ control ─▶ bus               stop and recovery, with a token
//! ```
//!
//! * **In:** non-real-time streams of the daemon, or a recording; files of the robot. **Out:** a
//!   page, or messages, on 127.0.0.1.
//! * **Invariants:** the process does not take part in the 1 kHz loop. The server answers only its
//!   own pages on this machine and loads nothing from elsewhere. Changes need the token. A page
//!   that does not read costs a bounded amount of memory.
//! * **Not included:** goals and parameters; they are in `atas`.

mod arena;
mod control;
mod displayed;
mod faults;
mod feed;
mod foxglove;
mod guard;
mod observe;
mod page;
mod picture;
mod polling;
mod recorded;
mod scene;
mod server;

use std::process::ExitCode;

use atas_console::arguments::Command;
use atas_console::{Exit, ExitError, Interrupt, Output};

fn main() -> ExitCode {
    atas_console::run(execute)
}

fn execute(command: &Command, interrupt: &Interrupt, output: &mut Output) -> anyhow::Result<()> {
    match command {
        Command::Dashboard(arguments) => server::dashboard(arguments, interrupt, output),
        Command::Foxglove(arguments) => foxglove::foxglove(arguments, interrupt, output),
        _ => Err(ExitError::with_code(
            Exit::Usage,
            "this program runs the observer commands only; run `atas` instead",
        )),
    }
}
