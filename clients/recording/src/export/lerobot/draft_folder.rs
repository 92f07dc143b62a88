//! Folder that appears under its name only when it is complete.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;

/// Incomplete folder next to its final path. Dropping it removes it unless it was published.
pub(super) struct DraftFolder {
    pub(super) path: PathBuf,
    out: PathBuf,
}

impl DraftFolder {
    /// Creates the folder; its final path must not exist.
    pub(super) fn next_to(out: &Path) -> anyhow::Result<Self> {
        reject_existing(out)?;
        let name = out.file_name().map(|name| name.to_string_lossy());
        let name = name.with_context(|| {
            format!(
                "could not make the folder {} because it has no name; name a folder",
                out.display()
            )
        })?;
        // The process id separates two simultaneous exports.
        let path = out.with_file_name(format!(".{name}.{}.part", std::process::id()));
        fs::create_dir(&path)
            .with_context(|| format!("could not make the folder {}", out.display()))?;
        Ok(Self {
            path,
            out: out.to_owned(),
        })
    }

    /// Moves the folder to its final path.
    pub(super) fn publish(self) -> anyhow::Result<()> {
        reject_existing(&self.out)?;
        fs::rename(&self.path, &self.out)
            .with_context(|| format!("could not make the folder {}", self.out.display()))
    }
}

impl Drop for DraftFolder {
    fn drop(&mut self) {
        // The folder is published or not needed.
        let _ = fs::remove_dir_all(&self.path);
    }
}

fn reject_existing(out: &Path) -> anyhow::Result<()> {
    anyhow::ensure!(
        !out.exists(),
        "could not make the folder {} because it exists; name another with --out, or remove it",
        out.display()
    );
    Ok(())
}
