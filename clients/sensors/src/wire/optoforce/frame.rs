//! Messages of the device, and their recognition.

use super::{DeviceStatus, checksum};
use crate::resync::{Candidate, Wire};

/// Largest number of values of a data frame: four channels of three axes.
pub const MAX_VALUES: usize = 12;

/// Bytes of every header.
const HEADER_LENGTH: usize = 4;

/// Kind of data frame; fixed per device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One three-axis dome.
    OneChannel,
    /// Four three-axis domes on one converter.
    FourChannel,
    /// One six-axis force/torque sensor.
    SixAxis,
}

impl Kind {
    /// Returns the number of values.
    #[must_use]
    pub const fn value_count(self) -> usize {
        match self {
            Self::OneChannel => 3,
            Self::FourChannel => 12,
            Self::SixAxis => 6,
        }
    }

    /// Returns the number of three-axis force sensors.
    #[must_use]
    pub const fn channel_count(self) -> usize {
        match self {
            Self::OneChannel | Self::SixAxis => 1,
            Self::FourChannel => 4,
        }
    }

    /// Returns the length of one frame: header, count, status, values, checksum.
    #[must_use]
    pub const fn length(self) -> usize {
        HEADER_LENGTH + 2 + 2 + 2 * self.value_count() + 2
    }
}

impl core::fmt::Display for Kind {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(match self {
            Self::OneChannel => "one-channel",
            Self::FourChannel => "four-channel",
            Self::SixAxis => "six-axis",
        })
    }
}

/// One valid data frame, in the device's counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DataFrame {
    /// Offset of its first byte from the beginning of the stream.
    pub byte_offset: u64,
    /// Kind of frame.
    pub kind: Kind,
    /// Frame counter of the device, wraps at 2^16.
    pub count: u16,
    /// Status of the device.
    pub status: DeviceStatus,
    values: [i16; MAX_VALUES],
}

impl DataFrame {
    /// Returns all values in wire order; their number is [`Kind::value_count`].
    #[must_use]
    pub fn values(&self) -> &[i16] {
        &self.values[..self.kind.value_count()]
    }

    /// Returns force counts `[Fx, Fy, Fz]` of every channel; their number is
    /// [`Kind::channel_count`]. Torques are omitted.
    pub fn forces(&self) -> impl ExactSizeIterator<Item = [i16; 3]> + '_ {
        (0..self.kind.channel_count())
            .map(|channel| core::array::from_fn(|axis| self.values[3 * channel + axis]))
    }

    fn from_bytes(kind: Kind, bytes: &[u8], byte_offset: u64) -> Self {
        let word = |index: usize| u16::from_be_bytes([bytes[index], bytes[index + 1]]);
        let mut values = [0; MAX_VALUES];
        for (index, value) in values.iter_mut().take(kind.value_count()).enumerate() {
            *value = word(HEADER_LENGTH + 4 + 2 * index).cast_signed();
        }
        let count = word(HEADER_LENGTH);
        let status = DeviceStatus(word(HEADER_LENGTH + 2));
        Self {
            byte_offset,
            kind,
            count,
            status,
            values,
        }
    }
}

/// Answer of the device to a configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Acknowledgement {
    /// Offset of its first byte from the beginning of the stream.
    pub byte_offset: u64,
    /// 0 if the device accepted the configuration.
    pub status: u8,
}

/// Message of the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Message {
    /// Reading.
    Data(DataFrame),
    /// Answer to a configuration.
    Acknowledgement(Acknowledgement),
}

/// Message that a header announces.
#[derive(Clone, Copy)]
enum Announced {
    Data(Kind),
    Acknowledgement,
}

/// All headers of a device. The last byte is the number of bytes between header and checksum.
const HEADERS: [([u8; HEADER_LENGTH], Announced); 4] = [
    ([0xAA, 0x07, 0x08, 0x0A], Announced::Data(Kind::OneChannel)),
    ([0xAA, 0x07, 0x08, 0x10], Announced::Data(Kind::SixAxis)),
    ([0xAA, 0x07, 0x08, 0x1C], Announced::Data(Kind::FourChannel)),
    ([0xAA, 0x00, 0x50, 0x01], Announced::Acknowledgement),
];

impl Announced {
    const fn length(self) -> usize {
        match self {
            Self::Data(kind) => kind.length(),
            Self::Acknowledgement => HEADER_LENGTH + 1 + 2,
        }
    }

    fn read(self, bytes: &[u8], byte_offset: u64) -> Message {
        match self {
            Self::Data(kind) => Message::Data(DataFrame::from_bytes(kind, bytes, byte_offset)),
            Self::Acknowledgement => Message::Acknowledgement(Acknowledgement {
                byte_offset,
                status: bytes[HEADER_LENGTH],
            }),
        }
    }
}

/// Wire format for the decoder.
#[derive(Clone, Copy, Debug, Default)]
pub struct Protocol;

impl Wire for Protocol {
    type Message = Message;
    const LENGTH_MAX: usize = Kind::FourChannel.length();
    const NESTED: bool = true;

    fn examine(&self, bytes: &[u8], byte_offset: u64) -> Candidate<Message> {
        examine(bytes, byte_offset)
    }

    fn is_data(message: &Message) -> bool {
        matches!(message, Message::Data(_))
    }
}

/// Examines the message that may begin at the first of `bytes`, which has the offset `byte_offset`.
fn examine(bytes: &[u8], byte_offset: u64) -> Candidate<Message> {
    let known = bytes.len().min(HEADER_LENGTH);
    let Some(&(_, announced)) = HEADERS
        .iter()
        .find(|(header, _)| header[..known] == bytes[..known])
    else {
        return Candidate::None;
    };
    // Every message is longer than its header, so an incomplete header also ends here.
    let Some(message) = bytes.get(..announced.length()) else {
        return Candidate::Undecided;
    };
    let (covered, sum) = message.split_at(message.len() - 2);
    if checksum(covered).to_be_bytes() != sum {
        return Candidate::Corrupt;
    }
    Candidate::Valid(announced.read(message, byte_offset), message.len())
}
