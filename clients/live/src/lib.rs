//! Library of `atas-live`: observation in a terminal, a browser or Foxglove, and teleoperation.
//!
//! ```text
//!  bus ─▶ observe (a thread) ─▶ Feed ─▶ server ─▶ page    live: pictures, events, faults
//!  recording ─▶ shelf ────────────────▶ server ─▶ page    recorded: the same pictures, by number
//!  bus ─▶ foxglove ─▶ entrance ─▶ ROS 2 messages over a WebSocket   live, for custom layouts
//!  page ─▶ server ─ guard ─▶ control ─▶ bus               stop and recovery, with a token
//!  bus ─▶ top ─▶ terminal                                 live: forces, modules, timing
//!  keyboard or file ─▶ teleop ─▶ bus                      stream of targets
//! ```
//!
//! * **In:** non-real-time streams of the daemon, or a recording; files of the robot. **Out:** a
//!   page, or messages, on 127.0.0.1, over a bounded number of connections.
//! * **Invariants:** the process does not take part in the 1 kHz loop. The server answers only its
//!   own pages on this machine and loads nothing from elsewhere. Changes need the token. A page
//!   that does not read costs a bounded amount of memory.
//! * **Not included:** goals other than teleoperation, and parameters; they are in `atas`.

mod arena;
mod connections;
mod control;
mod displayed;
mod entrance;
mod faults;
mod feed;
mod foxglove;
mod guard;
mod keys;
mod observe;
mod page;
mod picture;
mod polling;
mod recorded;
pub mod requests;
mod scene;
mod server;
mod teleop;
mod top;

use atas_console::arguments::Command;
use atas_console::{Exit, ExitError, Interrupt, Output};

/// Executes a command of this program.
///
/// # Errors
/// The command fails, or belongs to another program.
pub fn execute(
    command: &Command,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    match command {
        Command::Dashboard(arguments) => server::dashboard(arguments, interrupt, output),
        Command::Foxglove(arguments) => foxglove::foxglove(arguments, interrupt, output),
        Command::Teleop(arguments) => teleop::teleop(arguments, interrupt, output),
        Command::Top(bus) => top::top(bus, interrupt),
        _ => Err(ExitError::with_code(
            Exit::Usage,
            "this program runs dashboard, foxglove, teleop and top only; run `atas` instead",
        )),
    }
}
