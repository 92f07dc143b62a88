//! `atas-gate`: server side of the gate (see `lib.rs`).
//!
//! ```text
//!  standard input (listening socket) ─▶ door ─ a process per client ─▶ visit ─▶ rights ─▶ atas
//! ```
//!
//! systemd starts it as the bus's user with the socket as its standard input (`atas-gate.socket`).

mod connection;
mod permissions;
mod server;

use std::path::PathBuf;
use std::process::ExitCode;

use atas_process::command_line;
use atas_process::exit::Exit;
use clap::Parser;

/// Runs `atas` for members of group atas, as far as access.group of the configuration permits
#[derive(Debug, Parser)]
#[command(version, long_version = shm_bus::long_version())]
struct Args {
    /// Configuration file; repeatable, later files win [default: /etc/atas/atas.toml and
    /// /etc/atas/conf.d/*.toml]
    #[arg(long, value_name = "FILE")]
    config: Vec<PathBuf>,
    /// Standard input is the connection of one client instead of the listening socket
    #[arg(long, hide = true)]
    visit: bool,
    /// This client may only stop the robot: all connections are in use
    #[arg(long, hide = true, requires = "visit")]
    full: bool,
}

const PROGRAM: &str = "atas-gate";

fn main() -> ExitCode {
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(error) => return command_line::exit_without_work(PROGRAM, &error),
    };
    atas_process::run(
        PROGRAM,
        || {
            let done = if args.visit {
                connection::serve(&args.config, args.full)
            } else {
                server::serve(&args.config)
            };
            done.map_err(|error| format!("{error:#}"))
        },
        |_| Exit::Failed,
    )
}
