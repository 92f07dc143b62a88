//! Commands of the companion programs `atas-demo`, `atas-lab`, `atas-live` and `atas-remote`, which
//! replace this process with the same arguments.
//!
//! The programs are next to this one in a build or installation, otherwise on the PATH.

use std::io::ErrorKind;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::Command;

use anyhow::Context;
use atas_console::arguments::Program;

/// Replaces this process by the program. Returns only on failure.
pub(crate) fn exec_companion(program: Program) -> anyhow::Result<()> {
    let name = match program {
        Program::Operator => {
            anyhow::bail!(
                "internal error: `atas` does not implement one of its own commands; \
                please report this"
            )
        }
        Program::Demo => "atas-demo",
        Program::Lab => "atas-lab",
        Program::Live => "atas-live",
        Program::Remote => "atas-remote",
    };
    let program = path_next_to_this_program(name).unwrap_or_else(|| name.into());
    let error = Command::new(&program)
        .args(std::env::args_os().skip(1))
        .exec();
    if error.kind() == ErrorKind::NotFound {
        anyhow::bail!(
            "could not run the command: {name} is neither next to `atas` nor on the PATH; install \
             it, or build it with `cargo build --workspace`"
        );
    }
    Err(error).with_context(|| format!("could not start {}", program.display()))
}

/// Returns the path of a program in the folder of this one, if it exists.
pub(crate) fn path_next_to_this_program(name: &str) -> Option<PathBuf> {
    let this = std::env::current_exe().ok()?;
    let program = this.with_file_name(name);
    program.is_file().then_some(program)
}
