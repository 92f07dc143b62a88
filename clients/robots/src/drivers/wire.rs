//! An open serial port with the protocol that its servos speak: `rustypot`'s framing, our words for what goes wrong.

use std::error::Error;
use std::io;
use std::time::Duration;

use rustypot::{CommunicationErrorKind, DynamixelProtocolHandler, SyncReadError};
use serialport::SerialPort;

/// What passes over a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Protocol {
    /// Dynamixel protocol 1.0 as Feetech speaks it: the status of an answer is a set of alarms.
    One,
    /// Dynamixel protocol 2.0: the status of an answer is an error number, and an alert bit.
    Two,
}

/// Why an exchange with a servo failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WireError {
    /// No answer in time.
    #[error("servo {0} does not answer")]
    Silent(u8),
    /// An answer that is not whole, or not the servo's.
    #[error("what servo {0} answers is damaged")]
    Damaged(u8),
    /// The servo refused what it was told.
    #[error("servo {id} refuses it with error {code}")]
    Refused {
        /// Who.
        id: u8,
        /// The error number of the protocol.
        code: u8,
    },
    /// The servo holds in a way that is not ours.
    #[error(
        "servo {id} holds in mode {found}, needs mode {needed}; let it go first (atas-robot relax)"
    )]
    OtherMode {
        /// Who.
        id: u8,
        /// Its mode.
        found: u8,
        /// The mode that it should hold in.
        needed: u8,
    },
    /// The port itself failed.
    #[error("the port failed: {0}")]
    Port(String),
}

/// Bits of a status that are an error number in protocol 2.0; the other one is the alert.
const ERROR_BITS: u8 = 0x7F;

/// An open port.
pub struct Wire {
    port: Box<dyn SerialPort>,
    handler: DynamixelProtocolHandler,
    protocol: Protocol,
}

impl Wire {
    /// Opens a serial port (or a pseudo-terminal) for one process alone.
    ///
    /// # Errors
    /// A sentence that says what is wrong and what to do.
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
        let handler = match protocol {
            Protocol::One => DynamixelProtocolHandler::v1(),
            Protocol::Two => DynamixelProtocolHandler::v2(),
        };
        Ok(Self {
            port,
            handler,
            protocol,
        })
    }

    /// Reads all servos in one packet from now on, or each in a packet of its own (protocol 2.0).
    pub fn set_fast(&mut self, fast: bool) {
        self.handler.set_fast_sync_read(fast);
    }

    /// Everybody who answers.
    ///
    /// # Errors
    /// [`WireError::Port`].
    pub fn scan(&mut self) -> Result<Vec<u8>, WireError> {
        let found = self.handler.broadcast_ping(self.port.as_mut());
        found.map_err(|error| explained(0, error))
    }

    /// Reads registers of one servo.
    ///
    /// # Errors
    /// Every [`WireError`] but `OtherMode`.
    pub fn read(&mut self, id: u8, address: u8, length: u8) -> Result<Vec<u8>, WireError> {
        let answer = self
            .handler
            .read(self.port.as_mut(), id, address, length)
            .map_err(|error| explained(id, error))?;
        whole(id, answer, length)
    }

    /// Writes registers of one servo.
    ///
    /// # Errors
    /// Every [`WireError`] but `OtherMode`.
    pub fn write(&mut self, id: u8, address: u8, bytes: &[u8]) -> Result<(), WireError> {
        let status = self
            .handler
            .write_with_error(self.port.as_mut(), id, address, bytes)
            .map_err(|error| explained(id, error))?;
        let code = status.byte() & ERROR_BITS;
        if self.protocol == Protocol::Two && code != 0 {
            return Err(WireError::Refused { id, code });
        }
        Ok(())
    }

    /// Reads the same registers of several servos: for each its bytes, and the status of its answer.
    ///
    /// # Errors
    /// The first servo that fails.
    pub fn read_all(
        &mut self,
        ids: &[u8],
        address: u8,
        length: u8,
    ) -> Result<Vec<(Vec<u8>, u8)>, WireError> {
        let first = ids.first().copied().unwrap_or_default();
        let answers = self
            .handler
            .sync_read_with_error(self.port.as_mut(), ids, address, length)
            .map_err(|error| explained(first, error))?;
        let checked = ids.iter().zip(answers).map(|(&id, (bytes, status))| {
            whole(id, bytes, length).map(|bytes| (bytes, status.byte()))
        });
        checked.collect()
    }

    /// Writes the same registers of several servos. Nobody answers.
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
            .sync_write(self.port.as_mut(), ids, address, bytes)
            .map_err(|error| explained(first, error))
    }
}

fn whole(id: u8, bytes: Vec<u8>, length: u8) -> Result<Vec<u8>, WireError> {
    if bytes.len() == usize::from(length) {
        Ok(bytes)
    } else {
        Err(WireError::Damaged(id))
    }
}

/// What an error of `rustypot` means for the servo that was asked.
fn explained(id: u8, error: Box<dyn Error>) -> WireError {
    let error = match error.downcast::<SyncReadError>() {
        Ok(failed) => return explained(failed.id, failed.cause),
        Err(error) => error,
    };
    if let Some(error) = error.downcast_ref::<io::Error>() {
        return match error.kind() {
            io::ErrorKind::TimedOut => WireError::Silent(id),
            _ => WireError::Port(error.to_string()),
        };
    }
    match error.downcast_ref::<CommunicationErrorKind>() {
        Some(CommunicationErrorKind::TimeoutError) => WireError::Silent(id),
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
