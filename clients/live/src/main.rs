//! `atas-live`: looking on, in a browser or in Foxglove.
//!
//! ```text
//!  bus ─▶ observe (a thread) ─▶ Feed ─▶ server ─▶ page        live: pictures, events, faults, as they come
//!  recording ─▶ shelf ─────────────────▶ server ─▶ page        recorded: the same pictures, by their number
//!  bus ─▶ foxglove ─▶ ROS 2 messages over a WebSocket              live, for layouts of one's own
//!  page ─▶ server ─ guard ─▶ control ─▶ bus                    stop and recover, with a token
//! ```
//!
//! * **In:** the streams of the daemon's non-real-time side, or a recording; the files of the robot that runs. **Out:** a page, or messages, on 127.0.0.1.
//! * **Invariants:** an observer: nothing here is a peer of the 1 kHz loop. Only this machine is served, only pages of this
//!   server are answered, nothing is fetched from elsewhere. Whoever has no token changes nothing. A page that does not read
//!   costs a bounded amount of memory.
//! * **Absent on purpose:** goals and parameters: those are `atas`'s.

mod arena;
mod control;
mod faults;
mod feed;
mod foxglove;
mod guard;
mod observe;
mod page;
mod picture;
mod rounds;
mod scene;
mod server;
mod shelf;
mod shown;

use std::process::ExitCode;

use atas_console::arguments::Command;
use atas_console::{Ended, Exit, Interrupt, Output};

fn main() -> ExitCode {
    atas_console::run(execute)
}

fn execute(command: &Command, interrupt: &Interrupt, output: &mut Output) -> anyhow::Result<()> {
    match command {
        Command::Dashboard(arguments) => server::dashboard(arguments, interrupt, output),
        Command::Foxglove(arguments) => foxglove::foxglove(arguments, interrupt, output),
        _ => Err(Ended::with(
            Exit::Usage,
            "this is the part of the command that looks on; ask `atas` for it",
        )),
    }
}
