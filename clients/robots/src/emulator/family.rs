//! What two families of servos have in common for who plays them.

use super::shaft::{Orders, Shaft};

/// Registers of one servo.
pub(super) type Table = [u8; 256];

/// A request, for one servo or for all.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Request {
    /// Whom it is for; [`ALL`] for everybody.
    pub(super) id: u8,
    pub(super) what: What,
}

/// The id of everybody.
pub(super) const ALL: u8 = 0xFE;

/// What is asked.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum What {
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
        /// All in one packet.
        fast: bool,
    },
    SyncWrite {
        address: usize,
        items: Vec<(u8, Vec<u8>)>,
    },
    /// Something that these servos do not know.
    Unknown,
}

/// Why a servo refuses: the error number or alarm bits of its answer.
pub(super) type Error = u8;

/// A family: frames and registers.
pub(super) trait Family: Send + Sync {
    /// Registers as they are after the power came, of a servo with this model's name.
    fn registers(&self, model: &str, id: u8) -> Option<Table>;

    /// Sets the volatile registers as they are after the power came.
    fn boot(&self, table: &mut Table);

    /// What the registers tell the shaft to do.
    fn orders(&self, table: &Table) -> Orders;

    /// Switches torque in the registers.
    fn set_torque(&self, table: &mut Table, on: bool);

    /// Sets the complaints in the registers.
    fn complain(&self, table: &mut Table, bits: u8);

    /// Shows the shaft in the registers.
    fn show(&self, shaft: &Shaft, table: &mut Table);

    /// Writes registers, or refuses.
    fn write(&self, table: &mut Table, address: usize, bytes: &[u8]) -> Result<(), Error>;

    /// The status of an answer that serves what was asked.
    fn status(&self, table: &Table) -> u8;

    /// What a ping is answered with.
    fn ping(&self, table: &Table) -> Vec<u8>;

    /// Time until an answer begins, µs.
    fn return_delay_us(&self, table: &Table) -> u64;

    /// Takes the next request out of the bytes that came; what frames none is dropped.
    fn take(&self, bytes: &mut Vec<u8>) -> Option<Request>;

    /// An answer.
    fn answer(&self, id: u8, status: u8, parameters: &[u8]) -> Vec<u8>;

    /// The one packet with which so many servos answer a fast read, as far as those go that answer: id, status and registers of each.
    fn answer_together(&self, asked: usize, blocks: &[(u8, u8, Vec<u8>)]) -> Vec<u8>;
}
