//! `atas-gate`: the service's side of the gate (`lib.rs` says what it is).
//!
//! ```text
//!  standard input (a listening socket) ─▶ door ─ a process per visitor ─▶ visit ─▶ rights ─▶ atas
//! ```
//!
//! systemd starts it as the bus's user with the socket as its standard input (`atas-gate.socket`).

mod door;
mod rights;
mod visit;

use std::path::PathBuf;
use std::process::ExitCode;

use atas_process::command_line;
use clap::Parser;

/// Runs `atas` for members of group atas, as far as access.group of the configuration lets them.
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// Configuration file, may be repeated: later ones win [default: /etc/atas/atas.toml and /etc/atas/conf.d/*.toml].
    #[arg(long, value_name = "FILE")]
    config: Vec<PathBuf>,
    /// Standard input is one visitor instead of the socket that all knock at.
    #[arg(long, hide = true)]
    visit: bool,
    /// This visitor may only stop the robot: all places are taken.
    #[arg(long, hide = true, requires = "visit")]
    full: bool,
}

const PROGRAM: &str = "atas-gate";

fn main() -> ExitCode {
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(error) => return command_line::end(PROGRAM, &error, 1),
    };
    atas_process::run(
        PROGRAM,
        || {
            let done = if args.visit {
                visit::receive(&args.config, args.full)
            } else {
                door::keep(&args.config)
            };
            done.map_err(|error| format!("{error:#}"))
        },
        |_| 1,
    )
}
