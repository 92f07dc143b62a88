//! Shell completions and manual pages, generated from the command line definition.

use std::io::{self, Write};
use std::path::Path;

use clap::CommandFactory;

use crate::cli;
use crate::failure::Failure;

/// Prints completions.
pub(super) fn completions(shell: clap_complete::Shell) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(
        shell,
        &mut cli::Arguments::command(),
        "atas-robot",
        &mut script,
    );
    let mut out = io::stdout().lock();
    out.write_all(&script)
        .and_then(|()| out.flush())
        .map_err(Failure::Output)
}

/// Writes one page for the program and one per subcommand.
pub(super) fn pages(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)
        .and_then(|()| clap_mangen::generate_to(cli::Arguments::command(), folder))
        .map_err(|error| {
            Failure::Usage(format!(
                "could not write manual pages into {}: {error}",
                folder.display()
            ))
        })
}
