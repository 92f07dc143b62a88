//! `atas-demo`: `atas demo grasp|pick-place|screw|assembly`. This program has few dependencies, so
//! that the first command of the README builds quickly.

use std::process::ExitCode;

use atas_console::arguments::Command;
use atas_console::{Exit, ExitError};

fn main() -> ExitCode {
    atas_console::run(|command, interrupt, output| match command {
        Command::Demo { task } => atas_demo::demo(task, interrupt, output),
        _ => Err(ExitError::with_code(
            Exit::Usage,
            "this program runs demos only; run `atas` instead",
        )),
    })
}
