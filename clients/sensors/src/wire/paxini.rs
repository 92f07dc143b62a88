//! Paxini PX-6AX GEN3 fingertips behind the vendor's serial converter board (921,600 baud 8N1,
//! little-endian).
//!
//! The board is polled, one request per frame:
//!
//! | message | bytes | layout |
//! |---|---|---|
//! | request | 14 | `55 AA`, length − 5 (`u16`), device, 0, function, address (`u32`), size (`u16`), LRC |
//! | calibration | 15 | as request: function `79`, address 3, size 1, data `01` |
//! | reply | 15 + data | `AA 55`, the same fields, status, data, LRC |
//!
//! Function `FB` reads forces; the distributed force begins at address `0x40E`: per taxel `i8` x,
//! `i8` y, `u8` z in 0.1 N. The LRC is the two's complement of the sum of all bytes before it. The
//! reply to a write has no data. The board's firmware answers reads with status 1 although the data
//! are valid, so 0 and 1 both mean success.
//!
//! The thirteen bytes of a reply's header, which the request determines, identify it; so one byte
//! of checksum is enough. [`super::paxini_hand`] drives the high-speed board for whole hands, which
//! sends frames of another layout. Source: the vendor's protocol as the public `paxini-sdk`
//! implements it; `tests/independent_paxini.py` compares both.

use clap::{ArgMatches, Args, FromArgMatches, ValueEnum};

use crate::reading::{ByteCounts, Condition, Frame, Quantity, Shape};
use crate::resync::{Candidate, Resync, Wire};
use crate::wire::{DeviceMessages, Driver, Event, Interface, Request, SensorType, Zero};

/// Entry in the list of sensors.
pub const TYPE: SensorType = SensorType {
    name: "paxini",
    about: "Paxini PX-6AX GEN3 fingertip on the vendor's serial converter board",
    wire: "serial, 921600 baud 8N1, polled, frames with an 8-bit LRC",
    interface: Interface::Serial { baud: 921_600 },
    taxels: 31,
    rate_hz: "176",
    newtons_per_unit: Some("0.1,0.1,0.1"),
    axes: "z,x,y",
    zero: Zero::Device,
    example: "--device /dev/ttyUSB0 --hand left --model s2015e",
    notes: "",
    options: <Options as Args>::augment_args,
    driver: make,
};

/// Address of the distributed force (vendor's protocol).
const FORCE_ADDRESS: u32 = 0x40E;
/// Address of the calibration register (vendor's protocol).
const CALIBRATION_ADDRESS: u32 = 3;
/// Function code: read forces.
const READ_FORCE: u8 = 0xFB;
/// Function code: write the calibration register.
const CALIBRATE: u8 = 0x79;
/// Bytes before the data of a reply: header and status.
const REPLY_HEADER: usize = 14;
/// Taxels of the largest model whose frames fit one fingertip of the bus.
const MAX_TAXELS: usize = 52;

/// Models with at most 64 taxels, by the vendor's names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Model {
    /// DP-S1813-Elite: 31 taxels.
    S1813e,
    /// DP-S1813-Core: 51 taxels.
    S1813c,
    /// DP-S2015-Elite: 52 taxels.
    S2015e,
    /// IP-S1610-Elite: 25 taxels.
    S1610e,
}

impl Model {
    const fn taxels(self) -> usize {
        match self {
            Self::S1813e => 31,
            Self::S1813c => 51,
            Self::S2015e => 52,
            Self::S1610e => 25,
        }
    }
}

#[derive(Debug, Args)]
struct Options {
    /// Fingertip model, which the board does not report
    #[arg(long, value_enum, default_value = "s1813e")]
    model: Model,
    /// Number of the fingertip on the board's bus: its module number + 1.
    #[arg(long, default_value_t = 1)]
    id: u8,
}

fn make(matches: &ArgMatches, request: &Request) -> Result<Box<dyn Driver>, String> {
    let options = Options::from_arg_matches(matches).map_err(|error| error.to_string())?;
    let format = Format {
        device: options.id,
        taxels: options.model.taxels(),
    };
    Ok(Box::new(Paxini {
        zero: request.zero,
        decoder: Resync::new(format),
    }))
}

/// Reply format of one fingertip.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Number on the board's bus.
    pub device: u8,
    /// Number of taxels.
    pub taxels: usize,
}

/// Reply.
#[derive(Clone, Copy, Debug)]
pub enum Reply {
    /// Reply to a read: status, offset in the stream, and three bytes per taxel.
    Forces(u8, u64, [u8; 3 * MAX_TAXELS]),
    /// Reply to a write: status.
    Written(u8),
}

impl Format {
    fn request(&self) -> Vec<u8> {
        let length = (3 * self.taxels) as u16;
        message(self.device, READ_FORCE, FORCE_ADDRESS, length, &[])
    }

    /// Returns the first thirteen bytes of a reply with this many bytes of data.
    fn header(&self, function: u8, address: u32, carried: usize, asked: u16) -> [u8; 13] {
        let length = (REPLY_HEADER + carried + 1 - 5) as u16;
        header([0xAA, 0x55], length, self.device, function, address, asked)
    }
}

impl Wire for Format {
    type Message = Reply;
    const LENGTH_MAX: usize = REPLY_HEADER + 3 * MAX_TAXELS + 1;
    const NESTED: bool = true;

    fn examine(&self, bytes: &[u8], byte_offset: u64) -> Candidate<Reply> {
        let carried = 3 * self.taxels;
        let read = self.header(READ_FORCE, FORCE_ADDRESS, carried, carried as u16);
        let written = self.header(CALIBRATE, CALIBRATION_ADDRESS, 0, 1);
        let known = bytes.len().min(13);
        let carried = if bytes[..known] == read[..known] {
            carried
        } else if bytes[..known] == written[..known] {
            0
        } else {
            return Candidate::None;
        };
        let Some(reply) = bytes.get(..REPLY_HEADER + carried + 1) else {
            return Candidate::Undecided;
        };
        if reply.iter().fold(0_u8, |sum, &b| sum.wrapping_add(b)) != 0 {
            return Candidate::Corrupt;
        }
        let status = reply[13];
        let message = if carried == 0 {
            Reply::Written(status)
        } else {
            let mut data = [0; 3 * MAX_TAXELS];
            data[..carried].copy_from_slice(&reply[REPLY_HEADER..REPLY_HEADER + carried]);
            Reply::Forces(status, byte_offset, data)
        };
        Candidate::Valid(message, reply.len())
    }

    fn is_data(message: &Reply) -> bool {
        matches!(message, Reply::Forces(..))
    }
}

fn header(
    head: [u8; 2],
    length: u16,
    device: u8,
    function: u8,
    address: u32,
    data_length: u16,
) -> [u8; 13] {
    let [l0, l1] = length.to_le_bytes();
    let [a0, a1, a2, a3] = address.to_le_bytes();
    let [d0, d1] = data_length.to_le_bytes();
    [
        head[0], head[1], l0, l1, device, 0, function, a0, a1, a2, a3, d0, d1,
    ]
}

fn message(device: u8, function: u8, address: u32, data_length: u16, data: &[u8]) -> Vec<u8> {
    let length = (13 + data.len() + 1 - 5) as u16;
    let mut bytes = header([0x55, 0xAA], length, device, function, address, data_length).to_vec();
    bytes.extend(data);
    let sum = bytes.iter().fold(0_u8, |sum, &b| sum.wrapping_add(b));
    bytes.push(sum.wrapping_neg());
    bytes
}

/// Driver of one fingertip.
struct Paxini {
    zero: bool,
    decoder: Resync<Format>,
}

impl Paxini {
    fn format(&self) -> Format {
        *self.decoder.wire()
    }
}

impl Driver for Paxini {
    fn shape(&self) -> Shape {
        Shape {
            quantity: Quantity::Force,
            unit: "counts",
            fingers: 1,
            taxels: self.format().taxels,
        }
    }

    fn messages(&self) -> DeviceMessages {
        let format = self.format();
        let start = if self.zero {
            message(format.device, CALIBRATE, CALIBRATION_ADDRESS, 1, &[1])
        } else {
            Vec::new()
        };
        DeviceMessages {
            acknowledged: !start.is_empty(),
            start,
            poll: format.request(),
            ..DeviceMessages::default()
        }
    }

    fn receive(&mut self, bytes: &[u8], report: &mut dyn FnMut(Event<'_>)) {
        let taxels = self.format().taxels;
        self.decoder
            .push(bytes, |reply| report_reply(&reply, taxels, report));
    }

    fn finish(&mut self, report: &mut dyn FnMut(Event<'_>)) {
        let taxels = self.format().taxels;
        self.decoder
            .finish(|reply| report_reply(&reply, taxels, report));
    }

    fn counts(&self) -> ByteCounts {
        self.decoder.counts()
    }
}

fn report_reply(reply: &Reply, taxels: usize, report: &mut dyn FnMut(Event<'_>)) {
    match reply {
        Reply::Written(status) => report(Event::Acknowledged((*status).into())),
        Reply::Forces(status, byte_offset, data) => {
            let mut values = [0.0; 3 * MAX_TAXELS];
            for (value, taxel) in values.chunks_exact_mut(3).zip(data.chunks_exact(3)) {
                value[0] = f64::from(taxel[0].cast_signed());
                value[1] = f64::from(taxel[1].cast_signed());
                value[2] = f64::from(taxel[2]);
            }
            report(Event::Frame(Frame {
                byte_offset: *byte_offset,
                count: None,
                status: (*status).into(),
                temperature_c: None,
                condition: if *status <= 1 {
                    Condition::Normal
                } else {
                    Condition::Failed
                },
                values: &values[..3 * taxels],
            }));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Format, message};

    #[test]
    fn requests_equal_the_vendor_sdk() {
        let format = Format {
            device: 1,
            taxels: 52,
        };
        assert_eq!(
            format.request()[..13],
            [0x55, 0xAA, 9, 0, 1, 0, 0xFB, 0x0E, 4, 0, 0, 156, 0]
        );
        assert_eq!(
            message(1, 0xFB, 0x3F0, 3, &[]),
            [0x55, 0xAA, 9, 0, 1, 0, 0xFB, 0xF0, 3, 0, 0, 3, 0, 6]
        );
        assert_eq!(
            message(1, 0x79, 3, 1, &[1]),
            [0x55, 0xAA, 0x0A, 0, 1, 0, 0x79, 3, 0, 0, 0, 1, 0, 1, 0x78]
        );
    }
}
