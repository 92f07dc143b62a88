//! What can go wrong, in sentences a person can act on, and the exit codes of `ebts`.

use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

/// Why a command did not do what it was asked.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Something that was given cannot be used; nothing was changed.
    #[error("{0}")]
    Refused(String),
    /// Another process works on the same folder.
    #[error(
        "could not use folder {0} because another ebts works on it, needs a folder of its own; wait for it or name another --out"
    )]
    Busy(PathBuf),
    /// The operating system refused; what was finished before is safe.
    #[error(
        "could not {doing} {path} because {source}, needs a writable place with room; free some and run the same command again"
    )]
    Io {
        /// What was attempted.
        doing: &'static str,
        /// On which file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The bus could not be used.
    #[error(transparent)]
    Bus(#[from] shm_bus::BusError),
    /// Somebody pressed Ctrl-C; the sentence says what was saved.
    #[error("{0}")]
    Interrupted(String),
}

impl Error {
    /// The exit code where the system refused, a full disk for example.
    pub const SYSTEM: u8 = 5;

    /// A refusal in the house's form.
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

    /// A refusal by a part that already speaks in that form.
    pub fn from_part(error: impl Display) -> Self {
        Self::Refused(error.to_string())
    }

    /// What the system refused to do with a file.
    pub fn io(doing: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io {
            doing,
            path,
            source,
        }
    }

    /// The exit code of the process: 3 refused, 4 busy, 5 system, 6 bus, 130 interrupted. Clap uses 2 for bad usage; 0 is success.
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

/// What every fallible function of this crate returns.
pub type Result<T> = std::result::Result<T, Error>;
