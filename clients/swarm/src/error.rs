//! Errors of the crate and exit codes of `ebts`.

use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

use atas_process::exit::Exit;

/// Error of a command.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An input cannot be used; nothing was changed.
    #[error("{0}")]
    Refused(String),
    /// Another process works on the same folder.
    #[error(
        "could not use folder {0}: another ebts process uses it; wait until it ends or choose \
         another --out"
    )]
    Busy(PathBuf),
    /// The operating system reported an error; finished runs are safe.
    #[error(
        "could not {doing} {path}: {source}; check permissions and free disk space, then run the \
         same command again"
    )]
    Io {
        /// Attempted operation.
        doing: &'static str,
        /// File or folder.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The bus could not be used.
    #[error(transparent)]
    Bus(#[from] shm_bus::BusError),
    /// Interrupted with Ctrl-C; the text lists the saved files.
    #[error("{0}")]
    Interrupted(String),
}

impl Error {
    /// Builds a rejection: "could not WHAT: CAUSE, needs LIMIT; CURE".
    pub fn refused(
        what: impl Display,
        cause: impl Display,
        needs: impl Display,
        cure: impl Display,
    ) -> Self {
        Self::Refused(format!("could not {what}: {cause}, needs {needs}; {cure}"))
    }

    /// Wraps an error that already has this form.
    pub fn from_part(error: impl Display) -> Self {
        Self::Refused(error.to_string())
    }

    /// Returns a function that wraps an I/O error with operation and path.
    pub fn io(doing: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io {
            doing,
            path,
            source,
        }
    }

    /// Returns the exit code of the process.
    #[must_use]
    pub fn exit_code(&self) -> Exit {
        match self {
            Self::Refused(_) => Exit::Input,
            Self::Busy(_) => Exit::InUse,
            Self::Io { .. } => Exit::Failed,
            Self::Bus(error) if error.is_in_use() => Exit::InUse,
            Self::Bus(_) => Exit::Bus,
            Self::Interrupted(_) => Exit::Interrupted,
        }
    }
}

/// Result of the fallible functions of this crate.
pub type Result<T> = std::result::Result<T, Error>;
