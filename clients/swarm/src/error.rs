//! Errors of the crate and exit codes of `ebts`.

use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

/// Error of a command.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An input cannot be used; nothing was changed.
    #[error("{0}")]
    Refused(String),
    /// Another process works on the same folder.
    #[error(
        "could not use folder {0} because another ebts works on it, needs a folder of its own; wait for it or name another --out"
    )]
    Busy(PathBuf),
    /// The operating system reported an error; finished runs are safe.
    #[error(
        "could not {doing} {path} because {source}, needs a writable place with room; free some and run the same command again"
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
    /// Exit code of an operating system error, for example a full disk.
    pub const SYSTEM: u8 = 5;

    /// Builds a rejection: "could not WHAT: CAUSE, needs LIMIT; CURE".
    pub fn refused(
        what: impl Display,
        was: impl Display,
        needs: impl Display,
        cure: impl Display,
    ) -> Self {
        Self::Refused(format!(
            "could not {what} because {was}, needs {needs}; {cure}"
        ))
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

    /// Returns the exit code of the process: 3 rejected, 4 busy, 5 system, 6 bus, 130 interrupted.
    /// Clap uses 2 for wrong usage.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Refused(_) => 3,
            Self::Busy(_) => 4,
            Self::Io { .. } => Self::SYSTEM,
            Self::Bus(_) => 6,
            Self::Interrupted(_) => 130,
        }
    }
}

/// Result of the fallible functions of this crate.
pub type Result<T> = std::result::Result<T, Error>;
