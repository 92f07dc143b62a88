//! Shell completions and manual pages.

use std::io::{self, Write};
use std::path::Path;

use crate::cli;
use crate::failure::Failure;

pub(super) fn completions(shell: clap_complete::Shell) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut cli::command(), "atas-sensor", &mut script);
    let mut out = io::stdout().lock();
    out.write_all(&script)
        .and_then(|()| out.flush())
        .map_err(Failure::Table)
}

/// Writes one page per program and subcommand.
pub(super) fn pages(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)
        .and_then(|()| clap_mangen::generate_to(cli::command(), folder))
        .map_err(|error| {
            Failure::Usage(format!(
                "could not write manual pages into {}: {error}",
                folder.display()
            ))
        })
}
