//! The serial format of OptoForce / OnRobot OMD force sensors (1,000,000 baud 8N1, big-endian).
//!
//! | message | bytes | layout |
//! |---|---|---|
//! | configuration, to the device | 9 | `AA 00 32 03`, speed, filter, zero, checksum |
//! | acknowledgement | 7 | `AA 00 50 01`, status, checksum |
//! | data, one channel | 16 | `AA 07 08 0A`, count, status, Fx Fy Fz, checksum |
//! | data, six axes | 22 | `AA 07 08 10`, count, status, Fx Fy Fz Tx Ty Tz, checksum |
//! | data, four channels | 34 | `AA 07 08 1C`, count, status, 4 × (Fx Fy Fz), checksum |
//!
//! Count, status and checksum are `u16`, forces and torques `i16`, all in the device's counts. The
//! checksum is the sum of all preceding bytes, header included. The count wraps at 2^16. Source:
//! the vendor's protocol as public drivers implement it, and a recorded stream.
//!
//! # Definition of a message
//! *A message is at byte offset `i` of the stream if a complete header begins at `i` and its
//! checksum matches.* The [`Decoder`] reports **every** such message, in order of `i`, also
//! *inside* an accepted message. This matters: a frame that lost its last byte is completed by the
//! `AA` of the next frame if that byte was also `AA` (one frame in 256). Both frames are then
//! reported although they share one byte.
//!
//! # Limits
//! The checksum is a 16-bit sum, so some damaged frames pass it. Over all single-byte deletions,
//! single-byte insertions and truncations of every frame of the recorded stream, about 16 in a
//! million passed.

mod configuration;
mod device;
mod frame;
mod status;

pub use configuration::{Configuration, Filter, OutOfRange, STOP, Speed};
pub use device::TYPE;
pub use frame::{Acknowledgement, DataFrame, Kind, MAX_VALUES, Message, Protocol};
pub use status::DeviceStatus;

/// Decoder of a stream.
pub type Decoder = crate::resync::Resync<Protocol>;

/// Line speed of the serial interface, baud (vendor's protocol).
pub const BAUD: u32 = 1_000_000;

/// Returns the checksum of a message: the sum of its bytes so far, header included.
fn checksum(bytes: &[u8]) -> u16 {
    bytes
        .iter()
        .fold(0, |sum, &byte| sum.wrapping_add(u16::from(byte)))
}
