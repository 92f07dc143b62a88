//! An open serial port with the protocol of its servos: framing by `rustypot`, errors of this
//! crate.

use std::error::Error;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use rustypot::{CommunicationErrorKind, DynamixelProtocolHandler, SyncReadError};
use serialport::SerialPort;

use super::packet_port::PacketPort;
use super::protocol::Protocol;

/// Failure of an exchange with a servo.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WireError {
    /// No reply before the timeout.
    #[error("servo {0} does not answer")]
    NoReply(u8),
    /// Incomplete or invalid reply.
    #[error("the reply of servo {0} is damaged")]
    Damaged(u8),
    /// The servo rejected the request.
    #[error("servo {id} rejected the request with error {code}")]
    Rejected {
        /// Servo id.
        id: u8,
        /// Error number of the protocol.
        code: u8,
    },
    /// The servo has torque in another operating mode.
    #[error(
        "servo {id} holds in mode {found}, needs mode {needed}; switch its torque off first \
         (atas-robot relax)"
    )]
    WrongMode {
        /// Servo id.
        id: u8,
        /// Current mode.
        found: u8,
        /// Required mode.
        needed: u8,
    },
    /// The port failed.
    #[error("the port failed: {0}")]
    Port(String),
}

/// Bits of the error number in a status of protocol 2.0; the remaining bit is the alert.
const ERROR_BITS: u8 = 0x7F;

/// Attempts of an exchange with one servo. Design choice: with 2 % of damaged replies, one exchange
/// in 100,000 fails.
const ATTEMPTS: u32 = 3;

/// An open port.
pub struct Wire {
    port: PacketPort,
    handler: DynamixelProtocolHandler,
    protocol: Protocol,
    echoes: Arc<AtomicBool>,
}

impl Wire {
    /// Opens a serial port or pseudo-terminal for exclusive use.
    ///
    /// # Errors
    /// An error text with advice.
    pub fn open(
        device: &str,
        baud: u32,
        protocol: Protocol,
        answer_within: Duration,
    ) -> Result<Self, String> {
        let port = serialport::new(device, baud)
            .timeout(answer_within)
            .open()
            .map_err(|error| format!("could not open {device}: {error}; {}", advice(&error)))?;
        Ok(Self::with_port(port, protocol))
    }

    /// Uses an open port.
    #[must_use]
    pub fn with_port(port: Box<dyn SerialPort>, protocol: Protocol) -> Self {
        let handler = match protocol {
            Protocol::One => DynamixelProtocolHandler::v1(),
            Protocol::Two => DynamixelProtocolHandler::v2(),
        };
        let echoes = Arc::default();
        Self {
            port: PacketPort::new(port, protocol, Arc::clone(&echoes)),
            handler,
            protocol,
            echoes,
        }
    }

    /// Returns true if the adapter has echoed a request. Echoes are ignored.
    pub fn echoes(&self) -> bool {
        self.echoes.load(Ordering::Relaxed)
    }

    /// Selects whether sync reads return one packet for all servos or one per servo (protocol 2.0).
    pub fn set_fast(&mut self, fast: bool) {
        self.handler.set_fast_sync_read(fast);
    }

    /// Returns the ids of all servos that reply.
    ///
    /// # Errors
    /// [`WireError::Port`].
    pub fn scan(&mut self) -> Result<Vec<u8>, WireError> {
        let found = self.handler.broadcast_ping(&mut self.port);
        found.map_err(|error| wire_error(0, error))
    }

    /// Reads registers of one servo; repeats the request if the reply is missing or damaged.
    ///
    /// # Errors
    /// Every [`WireError`] except `WrongMode`.
    pub fn read(&mut self, id: u8, address: u8, length: u8) -> Result<Vec<u8>, WireError> {
        self.repeat(|wire| {
            let answer = wire.handler.read(&mut wire.port, id, address, length);
            check_length(id, answer.map_err(|error| wire_error(id, error))?, length)
        })
    }

    /// Writes registers of one servo; repeats the request if the reply is missing or damaged.
    ///
    /// # Errors
    /// Every [`WireError`] except `WrongMode`.
    pub fn write(&mut self, id: u8, address: u8, bytes: &[u8]) -> Result<(), WireError> {
        let status = self.repeat(|wire| {
            let status = wire
                .handler
                .write_with_error(&mut wire.port, id, address, bytes);
            status.map_err(|error| wire_error(id, error))
        })?;
        let code = status.byte() & ERROR_BITS;
        if self.protocol == Protocol::Two && code != 0 {
            return Err(WireError::Rejected { id, code });
        }
        Ok(())
    }

    /// Repeats an exchange whose reply is missing or damaged, after the line is quiet. Reads and
    /// writes of registers can be repeated.
    ///
    /// # Errors
    /// The error of the last attempt.
    pub fn repeat<T>(
        &mut self,
        mut exchange: impl FnMut(&mut Self) -> Result<T, WireError>,
    ) -> Result<T, WireError> {
        let mut result = exchange(self);
        for _ in 1..ATTEMPTS {
            if !matches!(result, Err(WireError::NoReply(_) | WireError::Damaged(_))) {
                break;
            }
            self.port.wait_until_quiet();
            result = exchange(self);
        }
        result
    }

    /// Reads the same registers of several servos; returns bytes and status of each.
    ///
    /// # Errors
    /// The error of the first servo that fails.
    pub fn read_all(
        &mut self,
        ids: &[u8],
        address: u8,
        length: u8,
    ) -> Result<Vec<(Vec<u8>, u8)>, WireError> {
        let first = ids.first().copied().unwrap_or_default();
        let answers = self
            .handler
            .sync_read_with_error(&mut self.port, ids, address, length)
            .map_err(|error| wire_error(first, error))?;
        let checked = ids.iter().zip(answers).map(|(&id, (bytes, status))| {
            check_length(id, bytes, length).map(|bytes| (bytes, status.byte()))
        });
        checked.collect()
    }

    /// Writes the same registers of several servos. Servos send no reply.
    ///
    /// # Errors
    /// [`WireError::Port`].
    pub fn write_all(
        &mut self,
        ids: &[u8],
        address: u8,
        bytes: &[Vec<u8>],
    ) -> Result<(), WireError> {
        let first = ids.first().copied().unwrap_or_default();
        self.handler
            .sync_write(&mut self.port, ids, address, bytes)
            .map_err(|error| wire_error(first, error))
    }
}

fn check_length(id: u8, bytes: Vec<u8>, length: u8) -> Result<Vec<u8>, WireError> {
    if bytes.len() == usize::from(length) {
        Ok(bytes)
    } else {
        Err(WireError::Damaged(id))
    }
}

/// Converts an error of `rustypot` in an exchange with servo `id`.
fn wire_error(id: u8, error: Box<dyn Error>) -> WireError {
    let error = match error.downcast::<SyncReadError>() {
        Ok(failed) => return wire_error(failed.id, failed.cause),
        Err(error) => error,
    };
    if let Some(error) = error.downcast_ref::<io::Error>() {
        return match error.kind() {
            io::ErrorKind::TimedOut => WireError::NoReply(id),
            io::ErrorKind::InvalidData => WireError::Damaged(id),
            _ => WireError::Port(error.to_string()),
        };
    }
    match error.downcast_ref::<CommunicationErrorKind>() {
        Some(CommunicationErrorKind::TimeoutError) => WireError::NoReply(id),
        Some(CommunicationErrorKind::Unsupported) | None => WireError::Port(error.to_string()),
        Some(_) => WireError::Damaged(id),
    }
}

fn advice(error: &serialport::Error) -> &'static str {
    match error.kind() {
        serialport::ErrorKind::NoDevice => {
            "check the path, that the adapter is plugged in (ls /dev/serial/by-id), and that no other process holds it"
        }
        serialport::ErrorKind::Io(io::ErrorKind::PermissionDenied) => {
            "add the user to the group that owns it (often dialout)"
        }
        _ => "check the adapter and its cable",
    }
}
