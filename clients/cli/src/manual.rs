//! Manual pages, generated from the command line.

use std::path::Path;

use anyhow::Context;
use atas_console::arguments;

pub(crate) fn write(folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder)
        .and_then(|()| clap_mangen::generate_to(arguments::command(), folder))
        .with_context(|| format!("could not write manual pages into {}", folder.display()))
}
