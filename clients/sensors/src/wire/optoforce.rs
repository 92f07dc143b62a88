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
//! Count, status and checksum are `u16`, forces and torques `i16`, all in the device's own counts. The checksum is the
//! sum of all preceding bytes, header included. The count wraps at 2^16. Source: the vendor's protocol as public
//! drivers implement it, and a recorded stream.
//!
//! # What is decoded, precisely
//! *A message stands at byte offset `i` of the stream when a complete header begins at `i` and the checksum that
//! belongs to it matches.* The [`Decoder`] reports **every** such message, in order of `i`, whatever surrounds it.
//! Junk, a truncated or corrupted neighbour, or a false header cannot hide a message, because after a failed candidate
//! the search goes on at the very next byte, and because it also goes on *inside* a message that was accepted.
//! The latter is not pedantry: a frame that lost its last byte is completed by the `AA` of the next frame whenever that
//! byte was itself `AA` (one frame in 256), and both frames are then reported although they share one byte.
//!
//! # How bytes are counted
//! Every byte belongs to exactly one of these, see [`ByteCounts`]:
//! * **data frame** or **acknowledgement**: it lies in a valid message; a byte shared by two is the first one's.
//! * **junk**: it lies in none, also when it is part of a truncated or corrupted frame.
//! * **pending**: at most 33 bytes at the end of what was received so far, which may still become a message.
//!   [`Decoder::finish`] settles them.
//!
//! A **checksum failure** is a complete header outside every valid message, followed by as many bytes as it announces,
//! whose checksum does not match. A candidate that the end of the stream cuts short is junk, not a failure.
//! **Lost frames** are the business of [`super::continuity`], which judges counts and never drops anything.
//!
//! # What no decoder can do
//! The checksum is a 16-bit sum, so a damaged frame passes it by chance. Over all single-byte deletions, single-byte
//! insertions and truncations of every frame of the recorded stream, about 16 in a million did.

mod configuration;
mod decoder;
mod frame;
mod status;

pub use configuration::{Configuration, Filter, OutOfRange, STOP, Speed};
pub use decoder::{ByteCounts, Decoder};
pub use frame::{Acknowledgement, DataFrame, Kind, MAX_VALUES, Message};
pub use status::DeviceStatus;

/// Line speed of the serial interface, baud (vendor's protocol).
pub const BAUD: u32 = 1_000_000;

/// The checksum of a message: the sum of its bytes so far, header included.
fn checksum(bytes: &[u8]) -> u16 {
    bytes
        .iter()
        .fold(0, |sum, &byte| sum.wrapping_add(u16::from(byte)))
}
