//! Remote operation: commands of `atas` at a daemon on another machine, over TLS.
//!
//! ```text
//!  atas --remote ─▶ client ─ frames over TLS ─▶ server ─┬─▶ atas (child) ─▶ bus of the daemon
//!       ◀─ standard output, standard error, exit code ──┤
//!                                                       └─▶ stop socket, without a child
//! ```
//!
//! The server runs the same command as a local user would, near the daemon. Output, JSON and exit
//! codes are therefore those of the local command. Each command has one connection, so no traffic
//! delays a stop.
//!
//! * **Input:** a command line, certificates, a configuration. **Output:** the streams and the exit
//!   code of the command.
//! * **Invariants**
//! * Both sides need a certificate of a configured authority. The configuration lists each client
//!   by name, with one right.
//! * The definition of the command line decides which commands pass
//!   ([`atas_console::arguments::Access`]), not their spelling.
//! * A client that closes the connection or is silent counts as dead: its command is killed. The
//!   daemon then treats an attached goal as that of a dead local client.
//! * Every foreign length is checked before memory is allocated. Connections, waiting data and
//!   times are bounded.
//! * A stop passes for each listed client, also when all connections are in use.
//! * **Not included:** a full-screen terminal, teleoperation, servers and files of the robot's
//!   machine, except its recordings.

mod client;
pub mod frame;
mod keys;
mod link;
mod message;
mod permission;
mod rejection;
mod server;
mod tls;

pub use message::{Reply, Request, Work};

use atas_console::arguments::{Arguments, Command, RemoteAction};
use atas_console::{Exit, ExitError, Interrupt, Output};

/// Version of frames and messages. Peers of different versions refuse each other.
pub const PROTOCOL: u32 = 1;
/// Application protocol in the TLS handshake.
pub const ALPN: &[u8] = b"atas-remote";

/// Executes a command of this program.
///
/// # Errors
/// The command fails, or belongs to another program.
pub fn execute(
    arguments: &Arguments,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    match (&arguments.command, &arguments.remote.remote) {
        (Command::Remote { action }, None) => match action {
            RemoteAction::Serve { config } => server::serve(config, interrupt),
            RemoteAction::Keys {
                out,
                hosts,
                clients,
                days,
            } => keys::create(out, hosts, clients, *days, output),
            RemoteAction::Check { .. } => Err(ExitError::with_code(
                Exit::Usage,
                "the check needs a server: add --remote NAME or --remote HOST:PORT",
            )),
        },
        (_, Some(_)) => client::run(arguments, interrupt, output),
        (_, None) => Err(ExitError::with_code(
            Exit::Usage,
            "this program runs `remote` and `--remote` only; run `atas` instead",
        )),
    }
}
