//! Common interface of the emulated servo families.

use super::shaft::{Shaft, ShaftSetpoints};

/// Registers of one servo.
pub(super) type Table = [u8; 256];

/// A request to one servo or to all.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Request {
    /// Servo id, or [`ALL`].
    pub(super) id: u8,
    pub(super) kind: RequestKind,
}

/// Broadcast id.
pub(super) const ALL: u8 = 0xFE;

/// Kind and parameters of a request.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum RequestKind {
    Ping,
    Read {
        address: usize,
        length: usize,
    },
    Write {
        address: usize,
        bytes: Vec<u8>,
    },
    Reboot,
    SyncRead {
        address: usize,
        length: usize,
        ids: Vec<u8>,
        /// All replies in one packet.
        fast: bool,
    },
    SyncWrite {
        address: usize,
        items: Vec<(u8, Vec<u8>)>,
    },
    /// Unsupported instruction.
    Unknown,
}

/// Error number or alarm bits of a reply.
pub(super) type Error = u8;

/// Frames and registers of a servo family.
pub(super) trait Family: Send + Sync {
    /// Returns the registers of a model after power-on; `None` for an unknown model.
    fn registers(&self, model: &str, id: u8) -> Option<Table>;

    /// Sets the volatile registers to their power-on values.
    fn boot(&self, table: &mut Table);

    /// Returns the set-points of the shaft from the registers.
    fn setpoints(&self, table: &Table) -> ShaftSetpoints;

    /// Sets the torque register.
    fn set_torque(&self, table: &mut Table, on: bool);

    /// Sets the error bits in the registers.
    fn set_errors(&self, table: &mut Table, bits: u8);

    /// Writes the shaft's state to the registers.
    fn write_shaft(&self, shaft: &Shaft, table: &mut Table);

    /// Writes registers, or returns an error.
    fn write(&self, table: &mut Table, address: usize, bytes: &[u8]) -> Result<(), Error>;

    /// Returns the status of a successful reply.
    fn status(&self, table: &Table) -> u8;

    /// Returns the reply parameters of a ping.
    fn ping(&self, table: &Table) -> Vec<u8>;

    /// Returns the delay before a reply, µs.
    fn return_delay_us(&self, table: &Table) -> u64;

    /// Removes the next valid request from `bytes`; drops bytes that belong to no request.
    fn take_request(&self, bytes: &mut Vec<u8>) -> Option<Request>;

    /// Returns the packet of a reply.
    fn answer(&self, id: u8, status: u8, parameters: &[u8]) -> Vec<u8>;

    /// Returns the reply to a fast read of `asked` servos; `blocks` has id, status and registers of
    /// each servo that replies.
    fn answer_together(&self, asked: usize, blocks: &[(u8, u8, Vec<u8>)]) -> Vec<u8>;
}
