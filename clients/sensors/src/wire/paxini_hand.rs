//! Paxini GEN3 fingertips on the vendor's high-speed board for whole hands (921,600 baud 8N1,
//! little-endian).
//!
//! The board sends frames without request once its register `0x17` is 1:
//!
//! | message | bytes | layout |
//! |---|---|---|
//! | write | 10 | `55 AA`, 0, function `10`, register (`u16`), length (`u16`) 1, data, LRC |
//! | reply | 10 | `AA 55`, 0, function `10`, register, length 1, status (0 valid), LRC |
//! | frame | 7 + data | `AA 56`, 0, data length + 1 (`u16`), error code, data, LRC |
//!
//! The data contain every connected module, in the order of the board's slots: thumb, index,
//! middle, ring and little finger, each with proximal, middle and distal phalanx and nail; then the
//! palm. A module has its total force (6 bytes, ignored here), then per taxel `i8` x, `i8` y, `u8`
//! z in 0.1 N. Register `0x16` selects the contents: bit 0 the total force, bit 1 the taxels. The
//! LRC is the two's complement of the sum of all bytes before it. A frame does not describe its
//! modules, so they are options; the five bytes that its length determines identify a frame. It has
//! no counter.
//!
//! Sources: two public implementations that agree, `paxini-utils` (after the vendor's viewer) and
//! `orca_core`; register `0x16` only from the latter. **Unknown**: the frame rate, which depends on
//! the modules (option `--rate-hz`); the meaning of error codes, so frames with one are rejected;
//! whether the reply always arrives, so the driver does not wait for it. Not included: the vendor's
//! zero command, of which only the bytes are public; this process zeroes.

use clap::{ArgMatches, Args, FromArgMatches};
use shm_schemas::capacity::FINGERS;

use crate::reading::{ByteCounts, Condition, Frame, Quantity, Shape};
use crate::resync::{Candidate, Resync, Wire};
use crate::wire::{DeviceMessages, Driver, Event, Interface, Request, SensorType, Zero};

/// Entry in the list of sensors.
pub const TYPE: SensorType = SensorType {
    name: "paxini-hand",
    about: "Paxini GEN3 fingertips of a whole hand on the vendor's high-speed board",
    wire: "serial, 921600 baud 8N1, pushed frames AA 56 with an 8-bit LRC",
    interface: Interface::Serial { baud: 921_600 },
    taxels: 31,
    rate_hz: "100",
    newtons_per_unit: Some("0.1,0.1,0.1"),
    axes: "z,x,y",
    zero: Zero::Host,
    example: "--device /dev/ttyACM0 --hand left --modules 31,31 --rate-hz 200",
    notes: "The rate of its frames depends on the modules and cannot be asked for: --rate-hz says what it is, `atas-sensor hz` \
            measures it. Frames of other modules than the named ones \
            count as junk. A frame of the bus has 64 elements per finger: a module with more taxels needs a --calibration that \
            makes one force of them.",
    options: <Options as Args>::augment_args,
    driver: make,
};

/// Number of module slots of the board.
const MODULES: usize = 28;
/// Addressable taxels per slot.
const TAXELS_MAX: usize = 170;
/// Bytes of a module's total force.
const TOTAL_FORCE_BYTES: usize = 6;
/// Bytes of a taxel.
const TAXEL_BYTES: usize = 3;
/// Bytes of a frame before its data.
const HEADER: usize = 6;
/// Register that selects the contents.
const CONTENT: u16 = 0x16;
/// Value for total forces and taxels, as the vendor's viewer expects it.
const ALL_CONTENT: u8 = 3;
/// Register that enables sending.
const PUSH: u16 = 0x17;
/// Function code: write a register.
const WRITE: u8 = 0x10;

#[derive(Debug, Args)]
struct Options {
    /// Taxels of every connected module, in the order of the board's slots.
    #[arg(
        long,
        value_name = "TAXELS",
        value_delimiter = ',',
        default_value = "31"
    )]
    modules: Vec<usize>,
    /// Fingertips among these modules, counted from 0 [default: all]
    #[arg(long, value_name = "MODULE", value_delimiter = ',')]
    fingertips: Vec<usize>,
}

fn make(matches: &ArgMatches, _request: &Request) -> Result<Box<dyn Driver>, String> {
    let options = Options::from_arg_matches(matches).map_err(|error| error.to_string())?;
    Ok(Box::new(PaxiniHand {
        decoder: Resync::new(Format::of(&options)?),
    }))
}

/// Frame format of one board with its modules.
#[derive(Clone, Debug)]
pub struct Format {
    /// Taxels of every module.
    modules: Vec<usize>,
    /// Indices of the fingertips.
    fingertips: Vec<usize>,
    /// Taxels of the largest fingertip.
    taxels: usize,
    /// Bytes of data with and without total forces.
    carried: [usize; 2],
}

/// Taxels of all fingertips, each with the size of the largest.
pub type Tips = [u8; TAXEL_BYTES * TAXELS_MAX * FINGERS];

/// Message of the board.
#[derive(Clone, Copy, Debug)]
pub struct Message {
    /// Offset of its first byte in the stream.
    byte_offset: u64,
    /// Error code of a frame, or status of a reply.
    status: u8,
    /// Fingertip data of a frame; `None` for the reply to a write.
    tips: Option<Tips>,
}

impl Format {
    fn of(options: &Options) -> Result<Self, String> {
        let modules = options.modules.clone();
        let is_module = |taxels: &usize| (1..=TAXELS_MAX).contains(taxels);
        if modules.is_empty() || modules.len() > MODULES || !modules.iter().all(is_module) {
            return Err(format!(
                "could not use --modules: needs 1 to {TAXELS_MAX} taxels for each of at most {MODULES} modules, such as 31,31"
            ));
        }
        let fingertips = match &*options.fingertips {
            [] => (0..modules.len()).collect(),
            named => named.to_vec(),
        };
        let is_there = |tip: &usize| *tip < modules.len();
        let is_once = |(n, tip): (usize, &usize)| !fingertips[..n].contains(tip);
        let each_once = fingertips.iter().enumerate().all(is_once);
        if fingertips.len() > FINGERS || !fingertips.iter().all(is_there) || !each_once {
            return Err(format!(
                "could not use --fingertips: needs at most {FINGERS} different ones of the {} modules, counted from 0",
                modules.len()
            ));
        }
        let taxels = fingertips.iter().map(|&tip| modules[tip]).max();
        let all: usize = modules.iter().sum();
        Ok(Self {
            taxels: taxels.unwrap_or(0),
            carried: [TOTAL_FORCE_BYTES, 0]
                .map(|before| before * modules.len() + TAXEL_BYTES * all),
            modules,
            fingertips,
        })
    }

    /// Returns the message that a header announces; `None` without a header.
    fn announced(&self, bytes: &[u8]) -> Option<Announced> {
        let known = |header: &[u8]| {
            let length = bytes.len().min(header.len());
            bytes[..length] == header[..length]
        };
        for (carried, before) in self.carried.into_iter().zip([TOTAL_FORCE_BYTES, 0]) {
            let [l0, l1] = (carried as u16 + 1).to_le_bytes();
            if known(&[0xAA, 0x56, 0, l0, l1]) {
                return Some(Announced::Forces { before, carried });
            }
        }
        let reply = |register| known(&header([0xAA, 0x55], register));
        let is_reply = [CONTENT, PUSH].into_iter().any(reply);
        is_reply.then_some(Announced::Written)
    }

    /// Returns the fingertips from the data, with `before` bytes before each module's taxels.
    /// Missing taxels of smaller fingertips read zero.
    fn tips(&self, data: &[u8], before: usize) -> Tips {
        let mut tips = [0; TAXEL_BYTES * TAXELS_MAX * FINGERS];
        for (place, &tip) in tips
            .chunks_exact_mut(TAXEL_BYTES * self.taxels)
            .zip(&self.fingertips)
        {
            let earlier: usize = self.modules[..tip].iter().sum();
            let start = before * (tip + 1) + TAXEL_BYTES * earlier;
            let length = TAXEL_BYTES * self.modules[tip];
            place[..length].copy_from_slice(&data[start..start + length]);
        }
        tips
    }
}

#[derive(Clone, Copy)]
enum Announced {
    Forces { before: usize, carried: usize },
    Written,
}

impl Wire for Format {
    type Message = Message;
    const LENGTH_MAX: usize = HEADER + MODULES * (TOTAL_FORCE_BYTES + TAXEL_BYTES * TAXELS_MAX) + 1;
    const NESTED: bool = true;

    fn examine(&self, bytes: &[u8], byte_offset: u64) -> Candidate<Message> {
        let Some(announced) = self.announced(bytes) else {
            return Candidate::None;
        };
        let length = match announced {
            Announced::Forces { carried, .. } => HEADER + carried + 1,
            Announced::Written => 10,
        };
        let Some(message) = bytes.get(..length) else {
            return Candidate::Undecided;
        };
        if message.iter().fold(0_u8, |sum, &b| sum.wrapping_add(b)) != 0 {
            return Candidate::Corrupt;
        }
        let message = match announced {
            Announced::Written => Message {
                byte_offset,
                status: message[8],
                tips: None,
            },
            Announced::Forces { before, carried } => Message {
                byte_offset,
                status: message[5],
                tips: Some(self.tips(&message[HEADER..HEADER + carried], before)),
            },
        };
        Candidate::Valid(message, length)
    }

    fn is_data(message: &Message) -> bool {
        message.tips.is_some()
    }
}

/// Returns the first eight bytes of a one-byte write, and of its reply.
fn header(head: [u8; 2], register: u16) -> [u8; 8] {
    let [r0, r1] = register.to_le_bytes();
    [head[0], head[1], 0, WRITE, r0, r1, 1, 0]
}

fn write(register: u16, value: u8) -> Vec<u8> {
    let mut bytes = header([0x55, 0xAA], register).to_vec();
    bytes.push(value);
    let sum = bytes.iter().fold(0_u8, |sum, &b| sum.wrapping_add(b));
    bytes.push(sum.wrapping_neg());
    bytes
}

/// Driver of one board.
struct PaxiniHand {
    decoder: Resync<Format>,
}

impl Driver for PaxiniHand {
    fn shape(&self) -> Shape {
        let format = self.decoder.wire();
        Shape {
            quantity: Quantity::Force,
            unit: "counts",
            fingers: format.fingertips.len(),
            taxels: format.taxels,
        }
    }

    fn messages(&self) -> DeviceMessages {
        DeviceMessages {
            start: [write(CONTENT, ALL_CONTENT), write(PUSH, 1)].concat(),
            repeat_start: true,
            stop: write(PUSH, 0),
            ..DeviceMessages::default()
        }
    }

    fn receive(&mut self, bytes: &[u8], report: &mut dyn FnMut(Event<'_>)) {
        let count = self.shape().values();
        self.decoder
            .push(bytes, |message| report_message(&message, count, report));
    }

    fn finish(&mut self, report: &mut dyn FnMut(Event<'_>)) {
        let count = self.shape().values();
        self.decoder
            .finish(|message| report_message(&message, count, report));
    }

    fn counts(&self) -> ByteCounts {
        self.decoder.counts()
    }
}

/// Reports a message; `count` values are those of the fingertips.
fn report_message(message: &Message, count: usize, report: &mut dyn FnMut(Event<'_>)) {
    let Message {
        byte_offset,
        status,
        tips: Some(tips),
    } = message
    else {
        return report(Event::Acknowledged(message.status.into()));
    };
    let mut values = [0.0; TAXEL_BYTES * TAXELS_MAX * FINGERS];
    for (value, taxel) in values
        .chunks_exact_mut(TAXEL_BYTES)
        .zip(tips.chunks_exact(TAXEL_BYTES))
    {
        value[0] = f64::from(taxel[0].cast_signed());
        value[1] = f64::from(taxel[1].cast_signed());
        value[2] = f64::from(taxel[2]);
    }
    report(Event::Frame(Frame {
        byte_offset: *byte_offset,
        count: None,
        status: (*status).into(),
        temperature_c: None,
        condition: if *status == 0 {
            Condition::Normal
        } else {
            Condition::Failed
        },
        values: &values[..count],
    }));
}

#[cfg(test)]
mod tests {
    use super::{ALL_CONTENT, CONTENT, PUSH, write};

    #[test]
    fn writes_equal_other_implementations() {
        assert_eq!(
            write(PUSH, 1),
            [0x55, 0xAA, 0, 0x10, 0x17, 0, 1, 0, 1, 0xD8]
        );
        assert_eq!(
            write(PUSH, 0),
            [0x55, 0xAA, 0, 0x10, 0x17, 0, 1, 0, 0, 0xD9]
        );
        let content = write(CONTENT, ALL_CONTENT);
        assert_eq!(content, [0x55, 0xAA, 0, 0x10, 0x16, 0, 1, 0, 3, 0xD7]);
    }
}
