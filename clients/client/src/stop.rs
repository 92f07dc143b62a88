//! Stop of the robot over every channel that the daemon has.

use std::time::Duration;

use shm_bus::{BusError, BusName, stop};
use shm_schemas::{ControlOp, StopOutcome};

use crate::session::Session;

/// Channel over which the daemon answered a stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopChannel {
    /// The stop socket ([`shm_bus::stop`]), which other clients cannot block.
    Socket,
    /// The control service on the bus, after the socket failed.
    Control,
}

impl StopChannel {
    /// Name in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Socket => "socket",
            Self::Control => "control",
        }
    }
}

/// The daemon's answer to a stop.
#[derive(Clone, Copy, Debug)]
pub struct StopReply {
    /// Channel of the answer.
    pub channel: StopChannel,
    /// Whether a tick has executed the stop.
    pub outcome: StopOutcome,
    /// Process id of the daemon in its own PID namespace; `None` over the control service.
    pub pid: Option<u32>,
}

/// Stops the robot until it is re-armed. Sends over the stop socket; without an answer also over
/// the control service.
///
/// # Errors
/// The error of the socket if both channels fail. A stop that was sent takes effect when the daemon
/// reads it.
pub fn request_stop(bus: &BusName, reason: &str, within: Duration) -> Result<StopReply, BusError> {
    let error = match stop::request(bus, reason, within) {
        Ok(answer) => {
            return Ok(StopReply {
                channel: StopChannel::Socket,
                outcome: answer.outcome,
                pid: Some(answer.pid),
            });
        }
        Err(error) => error,
    };
    let executed = Session::existing(bus)
        .and_then(|session| session.request_success(ControlOp::ESTOP, 0.0, reason));
    match executed {
        Ok(_) => Ok(StopReply {
            channel: StopChannel::Control,
            outcome: StopOutcome::STOPPED,
            pid: None,
        }),
        Err(_) => Err(error),
    }
}
