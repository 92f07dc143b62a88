//! The laboratory's commands: `atas-lab` takes this process over, with the same arguments.
//!
//! It lies beside this program where both are built or installed together, else on the PATH, as cargo and git find theirs.

use std::io::ErrorKind;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::Command;

use anyhow::Context;

/// The program.
const LAB: &str = "atas-lab";

/// Becomes `atas-lab`. Returns only if that is impossible.
pub(crate) fn hand_over() -> anyhow::Result<()> {
    let program = beside_this_program().unwrap_or_else(|| LAB.into());
    let error = Command::new(&program)
        .args(std::env::args_os().skip(1))
        .exec();
    if error.kind() == ErrorKind::NotFound {
        anyhow::bail!(
            "could not find {LAB}, which does this command, beside this program or on the PATH; install it, or build \
             everything with `cargo build --workspace`"
        );
    }
    Err(error).with_context(|| format!("could not start {}", program.display()))
}

fn beside_this_program() -> Option<PathBuf> {
    let this = std::env::current_exe().ok()?;
    let program = this.with_file_name(LAB);
    program.is_file().then_some(program)
}
