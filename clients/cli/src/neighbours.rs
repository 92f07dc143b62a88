//! Commands of the programs beside this one: they take this process over, with the same arguments.
//!
//! They lie beside this program where all are built or installed together, else on the PATH, as cargo and git find theirs.

use std::io::ErrorKind;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::Command;

use anyhow::Context;
use atas_console::arguments::Program;

/// Becomes the program. Returns only if that is impossible.
pub(crate) fn hand_over(program: Program) -> anyhow::Result<()> {
    let name = match program {
        Program::Operator => {
            anyhow::bail!("this program does not know its own command; report this")
        }
        Program::Lab => "atas-lab",
        Program::Live => "atas-live",
    };
    let program = beside_this_program(name).unwrap_or_else(|| name.into());
    let error = Command::new(&program)
        .args(std::env::args_os().skip(1))
        .exec();
    if error.kind() == ErrorKind::NotFound {
        anyhow::bail!(
            "could not find {name}, which does this command, beside this program or on the PATH; install it, or build \
             everything with `cargo build --workspace`"
        );
    }
    Err(error).with_context(|| format!("could not start {}", program.display()))
}

fn beside_this_program(name: &str) -> Option<PathBuf> {
    let this = std::env::current_exe().ok()?;
    let program = this.with_file_name(name);
    program.is_file().then_some(program)
}
