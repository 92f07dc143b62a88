//! Everything that ends a sensor process early, and the exit code it ends with.
//!
//! | code | meaning |
//! |---|---|
//! | 0 | stopped by SIGINT or SIGTERM, or a recording was decoded to its end |
//! | 1 | standard output could not be written; a closed pipe is no failure |
//! | 2 | the command line makes no sense |
//! | 3 | the device, or the recording to play, could not be opened |
//! | 4 | the device does not answer as configured |
//! | 5 | the device went away, or a recording ended in damage |
//! | 6 | the bus could not be used |
//!
//! The codes are stable: service managers and scripts may act on them.

/// Why a sensor process could not go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Failure {
    /// Standard output failed.
    #[error("could not write the table to standard output: {0}")]
    Table(#[source] std::io::Error),
    /// Arguments that contradict each other.
    #[error("{0}")]
    Usage(String),
    /// The device is missing, taken, or not what it should be.
    #[error("could not open {device}: {reason}")]
    Open {
        /// The path that was given.
        device: String,
        /// What is wrong and what to do.
        reason: String,
    },
    /// The configuration could not be sent, or was not answered, or was refused.
    #[error("could not configure {device}: {reason}")]
    Configure {
        /// The path that was given.
        device: String,
        /// What is wrong and what to do.
        reason: String,
    },
    /// The device is of another kind.
    #[error("could not use the data of {device}: it sends {found}")]
    WrongKind {
        /// The path that was given.
        device: String,
        /// What it sends, and the option that selects it.
        found: &'static str,
    },
    /// The device was there and is gone.
    #[error("lost {device}: {reason}; reconnect it and start again, or start with --reconnect")]
    Gone {
        /// The path that was given.
        device: String,
        /// What the operating system said.
        reason: String,
    },
    /// There is nothing to play.
    #[error("{0}")]
    Recording(String),
    /// A recording was played as far as it could be read.
    #[error("{0}")]
    Torn(String),
    /// The bus refused.
    #[error("{0}")]
    Bus(#[source] shm_bus::BusError),
}

impl Failure {
    /// The exit code of what could not be printed.
    pub const UNWRITTEN: u8 = 1;

    /// The exit code that stands for this failure.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Table(_) => Self::UNWRITTEN,
            Self::Usage(_) => 2,
            Self::Open { .. } | Self::Recording(_) => 3,
            Self::Configure { .. } | Self::WrongKind { .. } => 4,
            Self::Gone { .. } | Self::Torn(_) => 5,
            Self::Bus(_) => 6,
        }
    }

    /// Whether trying again later may help: what `--reconnect` waits for.
    #[must_use]
    pub fn may_pass(&self) -> bool {
        matches!(
            self,
            Self::Open { .. } | Self::Configure { .. } | Self::Gone { .. }
        )
    }
}
