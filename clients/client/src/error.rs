//! Errors of a client.

use std::path::PathBuf;
use std::time::Duration;

use shm_bus::{BusError, BusName, End};

use crate::standstill::Stopped;

/// Error of a client: no daemon, no answer, or a rejection.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// Error of the bus.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// No daemon reports its status.
    #[error(
        "could not find a daemon because nothing on bus {bus:?} (folder {}) reports its status; {}start `atasd`, or name \
         its bus with --bus or {}",
        folder.display(), end.as_ref().map_or(String::new(), |end| format!("{end}; ")), BusName::ENV
    )]
    NoDaemon {
        /// Name of the bus.
        bus: String,
        /// Folder of the bus.
        folder: PathBuf,
        /// End of the last daemon unless it was orderly.
        end: Option<End>,
    },
    /// The process of the daemon is stopped (suspended).
    #[error("no answer on bus {bus:?}: {stopped}")]
    Stopped {
        /// Name of the bus.
        bus: String,
        /// Owner of the bus.
        stopped: Stopped,
    },
    /// The daemon rejected the request.
    #[error("{0}")]
    Refused(String),
    /// The goal was cancelled, but its end was not confirmed.
    #[error(
        "cancelled the goal, but the daemon did not confirm it within {0:?}; see `atas status`, and stop the robot with \
         `atas estop` if in doubt"
    )]
    Unconfirmed(Duration),
}
