//! Draft: a file that gets its final name only when complete.

use std::fs::{self, File, OpenOptions};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use anyhow::Context;

/// Incomplete file next to its final path. Dropping it removes it unless it was published.
pub(super) struct Draft {
    path: PathBuf,
    out: PathBuf,
}

impl Draft {
    /// Creates the draft of a file, which must not exist.
    ///
    /// # Errors
    /// The file exists, or the path has no name.
    pub(super) fn next_to(out: &Path) -> anyhow::Result<Self> {
        reject_existing(out)?;
        let name = out.file_name().map(|name| name.to_string_lossy());
        let name = name.with_context(|| {
            format!(
                "could not make the file {} because it has no name; name a file",
                out.display()
            )
        })?;
        // The process id separates two simultaneous exports.
        let draft = format!(".{name}.{}.part", std::process::id());
        Ok(Self {
            path: out.with_file_name(draft),
            out: out.to_owned(),
        })
    }

    /// Opens the draft for writing.
    ///
    /// # Errors
    /// The folder does not exist or is not writable.
    pub(super) fn open(&self) -> anyhow::Result<File> {
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&self.path);
        file.with_context(|| format!("could not make the file {}", self.out.display()))
    }

    /// Gives the file its final name.
    ///
    /// # Errors
    /// Another program created a file of that name, or the folder is gone.
    pub(super) fn publish(self) -> anyhow::Result<()> {
        // Unlike a rename, a link never replaces another file. Some file systems have no links.
        match fs::hard_link(&self.path, &self.out) {
            Ok(()) => Ok(()),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => reject_existing(&self.out),
            Err(_) => {
                reject_existing(&self.out)?;
                fs::rename(&self.path, &self.out)
                    .with_context(|| format!("could not make the file {}", self.out.display()))
            }
        }
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        // The file is published or not needed.
        let _ = fs::remove_file(&self.path);
    }
}

fn reject_existing(out: &Path) -> anyhow::Result<()> {
    anyhow::ensure!(
        !out.exists(),
        "could not make the file {} because it exists; name another with --out, or remove it",
        out.display()
    );
    Ok(())
}
