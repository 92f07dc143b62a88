//! Why a daemon could not be asked.

use std::path::PathBuf;
use std::time::Duration;

use shm_bus::{BusError, BusName};

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
