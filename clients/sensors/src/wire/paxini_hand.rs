//! Paxini GEN3 fingertips on the vendor's high-speed board for whole hands (921,600 baud 8N1, little-endian).
//!
//! The board pushes frames by itself once its register `0x17` is 1:
//!
//! | message | bytes | layout |
//! |---|---|---|
//! | write, to the board | 10 | `55 AA`, 0, function `10`, register (`u16`), data length (`u16`) 1, data, LRC |
//! | reply to it | 10 | `AA 55`, 0, function `10`, register, data length 1, status (0 is well), LRC |
//! | frame | 7 + data | `AA 56`, 0, data length + 1 (`u16`), error code, data, LRC |
//!
//! The data are those of every connected module, in the order of the board's slots (thumb, index, middle, ring, little finger, of
//! each the proximal, middle and distal phalanx and the nail; then the palm): the force on the whole module, 6 bytes, which is
//! left out here, then per taxel `i8` x, `i8` y, `u8` z in 0.1 N. Register `0x16` says what of both is pushed: bit 0 the whole
//! force, bit 1 the taxels. The LRC is the two's complement of the sum of all bytes before it. A frame says nothing about its
//! modules, so they are options; a frame is recognised by the five bytes that its length fixes. It has no counter.
//!
//! Sources: two public implementations that agree with each other, `paxini-utils` (after the vendor's own viewer) and `orca_core`;
//! for the meaning of register `0x16` the latter alone. **Not known from them**: the rate of the frames, which depends on the
//! modules (`--rate-hz` says what it is); what the error codes mean, so a frame with one is not believed; whether the
//! reply always comes, so it is not waited for. Absent on purpose: the vendor's command that takes the zero, of
//! which only the bytes are public; the zero is taken here.

use clap::{ArgMatches, Args, FromArgMatches};
use shm_schemas::capacity::FINGERS;

use crate::reading::{ByteCounts, Condition, Frame, Quantity, Shape};
use crate::resync::{Candidate, Resync, Wire};
use crate::wire::{Dialogue, Driver, Event, Request, SensorType, Way, Zero};

/// The line in the list of sensors.
pub const TYPE: SensorType = SensorType {
    name: "paxini-hand",
    about: "Paxini GEN3 fingertips of a whole hand on the vendor's high-speed board",
    wire: "serial, 921600 baud 8N1, pushed frames AA 56 with an 8-bit LRC",
    way: Way::Serial { baud: 921_600 },
    taxels: 31,
    rate_hz: "100",
    newtons_per_unit: Some("0.1,0.1,0.1"),
    axes: "z,x,y",
    zero: Zero::Here,
    example: "--device /dev/ttyACM0 --hand left --modules 31,31 --rate-hz 200",
    notes: "The rate of its frames depends on the modules and cannot be asked for: --rate-hz says what it is, `atas-sensor hz` \
            measures it. Frames of other modules than the named ones \
            count as junk. A frame of the bus has 64 elements per finger: a module with more taxels needs a --calibration that \
            makes one force of them.",
    options: <Options as Args>::augment_args,
    driver: make,
};

/// Modules that the board has slots for.
const MODULES: usize = 28;
/// Taxels that a slot has addresses for.
const TAXELS_MAX: usize = 170;
/// Bytes of the force on a whole module.
const WHOLE: usize = 6;
/// Bytes of a taxel.
const TAXEL: usize = 3;
/// Bytes of a frame before its data.
const HEADER: usize = 6;
/// Register: what is pushed.
const CONTENT: u16 = 0x16;
/// Its value for the whole forces and the taxels, as the vendor's viewer expects it.
const EVERYTHING: u8 = 3;
/// Register: whether it is pushed.
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
    /// Which of these modules are the fingertips, counted from 0 [default: all].
    #[arg(long, value_name = "MODULE", value_delimiter = ',')]
    fingertips: Vec<usize>,
}

fn make(matches: &ArgMatches, _request: &Request) -> Result<Box<dyn Driver>, String> {
    let options = Options::from_arg_matches(matches).map_err(|error| error.to_string())?;
    Ok(Box::new(PaxiniHand {
        decoder: Resync::new(Format::of(&options)?),
    }))
}

/// The frames of one board with its modules.
#[derive(Clone, Debug)]
pub struct Format {
    /// Taxels of every module.
    modules: Vec<usize>,
    /// Places among them.
    fingertips: Vec<usize>,
    /// Taxels of the largest fingertip.
    taxels: usize,
    /// Bytes of data with and without the forces on whole modules.
    carried: [usize; 2],
}

/// The taxels of all fingertips, each with as many bytes as the largest.
pub type Tips = [u8; TAXEL * TAXELS_MAX * FINGERS];

/// One message.
#[derive(Clone, Copy, Debug)]
pub struct Message {
    /// Offset of its first byte in the stream.
    byte_offset: u64,
    /// Error code of a frame, or status of a reply.
    status: u8,
    /// What a frame says of the fingertips; `None` for the reply to a write.
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
            carried: [WHOLE, 0].map(|before| before * modules.len() + TAXEL * all),
            modules,
            fingertips,
        })
    }

    /// What a message that begins so would be; `None` if none does.
    fn announced(&self, bytes: &[u8]) -> Option<Announced> {
        let known = |header: &[u8]| {
            let length = bytes.len().min(header.len());
            bytes[..length] == header[..length]
        };
        for (carried, before) in self.carried.into_iter().zip([WHOLE, 0]) {
            let [l0, l1] = (carried as u16 + 1).to_le_bytes();
            if known(&[0xAA, 0x56, 0, l0, l1]) {
                return Some(Announced::Forces { before, carried });
            }
        }
        let reply = |register| known(&header([0xAA, 0x55], register));
        let is_reply = [CONTENT, PUSH].into_iter().any(reply);
        is_reply.then_some(Announced::Written)
    }

    /// The fingertips out of the data, with so many bytes before each module's taxels. One with fewer taxels than the largest
    /// feels nothing where it has none.
    fn tips(&self, data: &[u8], before: usize) -> Tips {
        let mut tips = [0; TAXEL * TAXELS_MAX * FINGERS];
        for (place, &tip) in tips
            .chunks_exact_mut(TAXEL * self.taxels)
            .zip(&self.fingertips)
        {
            let earlier: usize = self.modules[..tip].iter().sum();
            let start = before * (tip + 1) + TAXEL * earlier;
            let length = TAXEL * self.modules[tip];
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
    const LONGEST: usize = HEADER + MODULES * (WHOLE + TAXEL * TAXELS_MAX) + 1;
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

/// The first eight bytes of a write of one byte, and of the reply to it.
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

/// One board.
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

    fn dialogue(&self) -> Dialogue {
        Dialogue {
            start: [write(CONTENT, EVERYTHING), write(PUSH, 1)].concat(),
            insist: true,
            stop: write(PUSH, 0),
            ..Dialogue::default()
        }
    }

    fn receive(&mut self, bytes: &[u8], report: &mut dyn FnMut(Event<'_>)) {
        let count = self.shape().values();
        self.decoder
            .push(bytes, |message| pass_on(&message, count, report));
    }

    fn finish(&mut self, report: &mut dyn FnMut(Event<'_>)) {
        let count = self.shape().values();
        self.decoder
            .finish(|message| pass_on(&message, count, report));
    }

    fn counts(&self) -> ByteCounts {
        self.decoder.counts()
    }
}

/// Reports a message; `count` values are those of the fingertips.
fn pass_on(message: &Message, count: usize, report: &mut dyn FnMut(Event<'_>)) {
    let Message {
        byte_offset,
        status,
        tips: Some(tips),
    } = message
    else {
        return report(Event::Acknowledged(message.status.into()));
    };
    let mut values = [0.0; TAXEL * TAXELS_MAX * FINGERS];
    for (value, taxel) in values.chunks_exact_mut(TAXEL).zip(tips.chunks_exact(TAXEL)) {
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
            Condition::Well
        } else {
            Condition::Failed
        },
        values: &values[..count],
    }));
}

#[cfg(test)]
mod tests {
    use super::{CONTENT, EVERYTHING, PUSH, write};

    #[test]
    fn writes_match_what_other_implementations_send() {
        assert_eq!(
            write(PUSH, 1),
            [0x55, 0xAA, 0, 0x10, 0x17, 0, 1, 0, 1, 0xD8]
        );
        assert_eq!(
            write(PUSH, 0),
            [0x55, 0xAA, 0, 0x10, 0x17, 0, 1, 0, 0, 0xD9]
        );
        let content = write(CONTENT, EVERYTHING);
        assert_eq!(content, [0x55, 0xAA, 0, 0x10, 0x16, 0, 1, 0, 3, 0xD7]);
    }
}
