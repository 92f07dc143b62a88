//! `ebts completions` and `ebts man`, generated from the command line definition.

use std::path::PathBuf;

use clap::{Args, Command};
use serde::Serialize;

use ebts::error::{Error, Result};

use super::{Format, answer, print};

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  ebts completions bash > ~/.local/share/bash-completion/completions/ebts"
)]
pub(crate) struct CompletionsArgs {
    /// Shell.
    #[arg(value_enum)]
    shell: clap_complete::Shell,
}

pub(super) fn completions(args: CompletionsArgs, command: &mut Command) -> Result<()> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, command, "ebts", &mut text);
    print(&text)
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  ebts man man1 && man man1/ebts-evolve.1")]
pub(crate) struct ManArgs {
    /// Output folder.
    folder: PathBuf,
}

#[derive(Serialize)]
struct Written {
    folder: PathBuf,
}

pub(super) fn pages(args: ManArgs, command: Command, format: Format) -> Result<()> {
    let folder = args.folder;
    std::fs::create_dir_all(&folder)
        .and_then(|()| clap_mangen::generate_to(command, &folder))
        .map_err(Error::io("write manual pages into", &folder))?;
    let written = Written { folder };
    answer(format, &written, || {
        format!("manual pages: {}", written.folder.display())
    })
}
