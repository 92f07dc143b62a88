//! Why a daemon could not be asked.

use std::path::PathBuf;
use std::time::Duration;

use shm_bus::{BusError, BusName};

use crate::standstill::Stopped;

/// Why a daemon could not be asked, or did not answer.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Nothing reports its status.
    #[error(
        "could not find a daemon because nothing on bus {bus:?} (folder {}) reports its status; start `atasd`, or name its \
         bus with --bus or {}", folder.display(), BusName::ENV
    )]
    NoDaemon {
        /// Name of the bus.
        bus: String,
        /// Its folder.
        folder: PathBuf,
    },
    /// There is a daemon, and its process is stopped.
    #[error("could not ask on bus {bus:?} because {stopped}")]
    Stopped {
        /// Name of the bus.
        bus: String,
        /// Its owner.
        stopped: Stopped,
    },
    /// The daemon understood and refused.
    #[error("{0}")]
    Refused(String),
    /// A goal was cancelled, but its end was not confirmed.
    #[error(
        "cancelled the goal, but the daemon did not confirm it within {0:?}; see `atas status`, and stop the robot with \
         `atas estop` if in doubt"
    )]
    Unconfirmed(Duration),
}
