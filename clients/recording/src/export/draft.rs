//! A file that gets its name when it is whole.

use std::fs::{self, File, OpenOptions};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use anyhow::Context;

/// A file in the making, beside the one that it shall be. Dropped before it is published, it is removed.
pub(super) struct Draft {
    path: PathBuf,
    out: PathBuf,
}

impl Draft {
    /// Beside this file, which must not exist.
    ///
    /// # Errors
    /// It exists, or it has no name.
    pub(super) fn beside(out: &Path) -> anyhow::Result<Self> {
        refuse(out)?;
        let name = out.file_name().map(|name| name.to_string_lossy());
        let name = name.with_context(|| {
            format!(
                "could not make the file {} because it has no name; name a file",
                out.display()
            )
        })?;
        // With the process in it: two exports at a time are two files.
        let draft = format!(".{name}.{}.part", std::process::id());
        Ok(Self {
            path: out.with_file_name(draft),
            out: out.to_owned(),
        })
    }

    /// Opens it to be written.
    ///
    /// # Errors
    /// Its folder is not there, or may not be written.
    pub(super) fn open(&self) -> anyhow::Result<File> {
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&self.path);
        file.with_context(|| format!("could not make the file {}", self.out.display()))
    }

    /// Gives it its name.
    ///
    /// # Errors
    /// A file of that name has been made meanwhile, or the folder is gone.
    pub(super) fn publish(self) -> anyhow::Result<()> {
        // A link, unlike a rename, never takes the place of another file. Not every file system has links.
        match fs::hard_link(&self.path, &self.out) {
            Ok(()) => Ok(()),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => refuse(&self.out),
            Err(_) => {
                refuse(&self.out)?;
                fs::rename(&self.path, &self.out)
                    .with_context(|| format!("could not make the file {}", self.out.display()))
            }
        }
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        // It has its name, or is not wanted.
        let _ = fs::remove_file(&self.path);
    }
}

fn refuse(out: &Path) -> anyhow::Result<()> {
    anyhow::ensure!(
        !out.exists(),
        "could not make the file {} because it exists; name another with --out, or remove it",
        out.display()
    );
    Ok(())
}
