//! Failures that end a sensor process early, and their exit codes.

use atas_process::exit::Exit;
use shm_bus::BusError;

/// Failure of a sensor process.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Failure {
    /// Standard output failed.
    #[error("could not write the table to standard output: {0}")]
    Table(#[source] std::io::Error),
    /// Invalid or contradictory arguments.
    #[error("{0}")]
    Usage(String),
    /// The device is missing, in use, or of the wrong kind of file.
    #[error("could not open {device}: {reason}")]
    Open {
        /// Path or address.
        device: String,
        /// Cause and remedy.
        reason: String,
    },
    /// The configuration could not be sent, or was unanswered or refused.
    #[error("could not configure {device}: {reason}")]
    Configure {
        /// Path or address.
        device: String,
        /// Cause and remedy.
        reason: String,
    },
    /// The device is another type of sensor.
    #[error("could not use the data of {device}: it sends {found}")]
    WrongKind {
        /// Path or address.
        device: String,
        /// Type of its data, and the option that selects it.
        found: &'static str,
    },
    /// The device was disconnected.
    #[error("lost {device}: {reason}; reconnect it and start again, or start with --reconnect")]
    Disconnected {
        /// Path or address.
        device: String,
        /// Operating system error.
        reason: String,
    },
    /// The recording has nothing to play.
    #[error("{0}")]
    Recording(String),
    /// A recording was played up to its damage.
    #[error("{0}")]
    RecordingDamaged(String),
    /// A bus operation failed.
    #[error("{0}")]
    Bus(#[source] BusError),
}

impl Failure {
    /// Returns the exit code.
    #[must_use]
    pub fn exit_code(&self) -> Exit {
        match self {
            Self::Table(_) => Exit::Failed,
            Self::Usage(_) => Exit::Usage,
            Self::Recording(_) | Self::RecordingDamaged(_) => Exit::Input,
            Self::Open { .. }
            | Self::Configure { .. }
            | Self::WrongKind { .. }
            | Self::Disconnected { .. } => Exit::Device,
            Self::Bus(error) if error.is_in_use() => Exit::InUse,
            Self::Bus(_) => Exit::Bus,
        }
    }

    /// Returns whether `--reconnect` may try again.
    #[must_use]
    pub fn is_transient(&self) -> bool {
        matches!(
            self,
            Self::Open { .. } | Self::Configure { .. } | Self::Disconnected { .. }
        )
    }
}
