//! Contactile PapillArray sensors behind the vendor's controller, over USB CDC (PTSCOM 2.0,
//! little-endian).
//!
//! | message | layout |
//! |---|---|
//! | packet | `55 66 77 88`, index size (`u8`), table, blocks, checksum (`u16`), `AA BB CC DD` |
//! | table | per block: type (`u16`), offset after the start mark (index size bytes) |
//! | block 1 | packet counter (`u32`), time in µs (`u64`) |
//! | block 3 | sensors (`u16`), their offsets; per sensor: pillars (`u16`), their offsets |
//! | pillar | 2 (`u16`), Fx Fy Fz in N, Dx Dy Dz in mm (`f32`) |
//! | command | ASCII lines: `f100`, `f250`, `f500`, `f1000` set the rate, `z` zeroes |
//!
//! The checksum is the sum of all bytes after the start mark. Other blocks (global force, slip,
//! friction) are ignored. The end mark may occur inside floats, so every end mark within the
//! longest packet is tried until checksum and structure match; the checksum also rejects false
//! start marks. Source: PTSCOM_2.0_SPEC_SEP22 of the vendor, and a public third-party decoder for
//! the block layouts.

// Numbers of a file or a device reach this arithmetic.
#![warn(clippy::arithmetic_side_effects)]

use clap::{ArgMatches, Args, FromArgMatches};

use crate::reading::{ByteCounts, Condition, Frame, Quantity, Shape};
use crate::resync::{Candidate, Resync, Wire};
use crate::wire::{DeviceMessages, Driver, Event, Interface, Request, SensorType, Zero};

/// Entry in the list of sensors.
pub const TYPE: SensorType = SensorType {
    name: "papillarray",
    about: "Contactile PapillArray: nine pillars per sensor, one or two sensors on a controller",
    wire: "serial over USB CDC, little-endian packets with a 16-bit sum",
    interface: Interface::Serial { baud: 115_200 },
    taxels: 9,
    rate_hz: "1000",
    newtons_per_unit: Some("1,1,1"),
    axes: "z,x,y",
    zero: Zero::Device,
    example: "--device /dev/ttyACM0 --hand left --sensors 2 --zero",
    notes: "",
    options: <Options as Args>::augment_args,
    driver: make,
};

const START: [u8; 4] = [0x55, 0x66, 0x77, 0x88];
const END: [u8; 4] = [0xAA, 0xBB, 0xCC, 0xDD];
/// Longest accepted packet, bytes. Two sensors with every known block take 854. Design choice: a
/// larger limit would delay the packets after a damaged one.
const PACKET_MAX: usize = 1024;
/// Pillars of one sensor.
const PILLARS: usize = 9;
/// Sensors of one controller.
const MAX_SENSORS: usize = 2;
/// Bytes of one pillar's entry in block 3.
const PILLAR_BYTES: usize = 26;

#[derive(Debug, Args)]
struct Options {
    /// Sensors on the controller: sensor i is finger i of the device
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=MAX_SENSORS as u64))]
    sensors: u64,
}

fn make(matches: &ArgMatches, request: &Request) -> Result<Box<dyn Driver>, String> {
    let options = Options::from_arg_matches(matches).map_err(|error| error.to_string())?;
    if ![100, 250, 500, 1000].contains(&request.rate_hz) {
        return Err(format!(
            "could not use --rate-hz: the controller has no rate of {} Hz, needs one of 100, 250, 500, 1000",
            request.rate_hz
        ));
    }
    Ok(Box::new(PapillArray {
        request: *request,
        sensors: options.sensors as usize,
        decoder: Resync::default(),
    }))
}

/// Packet format of a controller.
#[derive(Clone, Copy, Debug, Default)]
pub struct Format;

/// Pillar forces of one packet.
#[derive(Clone, Copy, Debug)]
pub struct Packet {
    byte_offset: u64,
    counter: u32,
    sensors: usize,
    forces_n: [f64; 3 * PILLARS * MAX_SENSORS],
}

impl Wire for Format {
    type Message = Packet;
    const LENGTH_MAX: usize = PACKET_MAX;
    const NESTED: bool = true;

    fn examine(&self, bytes: &[u8], byte_offset: u64) -> Candidate<Packet> {
        let known = bytes.len().min(START.len());
        if bytes[..known] != START[..known] {
            return Candidate::None;
        }
        let bytes = &bytes[..bytes.len().min(PACKET_MAX)];
        let Some(body) = bytes.get(START.len()..) else {
            return Candidate::Undecided;
        };
        let mut sum = 0_u16;
        let mut summed = 0;
        for end in body
            .windows(END.len())
            .enumerate()
            .filter(|(_, w)| *w == END)
            .map(|(at, _)| at)
        {
            let Some(covered) = end.checked_sub(2) else {
                continue;
            };
            sum = body[summed..covered]
                .iter()
                .fold(sum, |sum, &byte| sum.wrapping_add(byte.into()));
            summed = covered;
            if u16_at(body, covered) == Some(sum)
                && let Some(packet) = parse(&body[..covered], byte_offset)
            {
                let length = const { START.len() + END.len() }.saturating_add(end);
                return Candidate::Valid(packet, length);
            }
        }
        if bytes.len() < PACKET_MAX && may_be_packet(body) {
            Candidate::Undecided
        } else {
            Candidate::Corrupt
        }
    }

    fn is_data(_message: &Packet) -> bool {
        true
    }
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    let word = bytes.get(at..)?.first_chunk()?;
    Some(u16::from_le_bytes(*word))
}

/// Returns an offset of `size` bytes.
fn offset_at(bytes: &[u8], at: usize, size: usize) -> Option<usize> {
    let bytes = bytes.get(at..)?.get(..size)?;
    Some(
        bytes
            .iter()
            .rev()
            .fold(0, |value, &byte| value << 8 | usize::from(byte)),
    )
}

/// Returns the starts of blocks 1 and 3. The table ends where the first block begins.
fn table(body: &[u8]) -> Option<(usize, usize)> {
    let size = usize::from(*body.first()?);
    if !(1..=4).contains(&size) {
        return None;
    }
    let (mut at, mut first) = (1_usize, body.len());
    let (mut hub, mut pillars) = (None, None);
    loop {
        let number = at.saturating_add(2);
        let next = number.saturating_add(size);
        if next > first {
            break;
        }
        let offset = offset_at(body, number, size)?;
        match u16_at(body, at)? {
            1 => hub = Some(offset),
            3 => pillars = Some(offset),
            _ => {}
        }
        first = first.min(offset);
        at = next;
    }
    Some((hub?, pillars?))
}

/// Returns the offset after a count and that many offsets.
fn skip(at: usize, count: usize, size: usize) -> Option<usize> {
    count.checked_mul(size)?.checked_add(2)?.checked_add(at)
}

/// Returns the packet if its blocks lie inside it and have the expected structure.
fn parse(body: &[u8], byte_offset: u64) -> Option<Packet> {
    let size = usize::from(*body.first()?);
    let (hub, mut at) = table(body)?;
    let counter = u32::from_le_bytes(*body.get(hub..)?.first_chunk()?);
    let sensors = usize::from(u16_at(body, at)?);
    if !(1..=MAX_SENSORS).contains(&sensors) {
        return None;
    }
    at = skip(at, sensors, size)?;
    let mut forces_n = [0.0; 3 * PILLARS * MAX_SENSORS];
    for sensor in forces_n.chunks_exact_mut(3 * PILLARS).take(sensors) {
        if usize::from(u16_at(body, at)?) != PILLARS {
            return None;
        }
        at = skip(at, PILLARS, size)?;
        for pillar in sensor.chunks_exact_mut(3) {
            let entry = body.get(at..)?.first_chunk::<PILLAR_BYTES>()?;
            let (words, _) = entry[2..14].as_chunks::<4>();
            for (force_n, &word) in pillar.iter_mut().zip(words) {
                *force_n = f32::from_le_bytes(word).into();
            }
            at = at.checked_add(PILLAR_BYTES)?;
        }
    }
    Some(Packet {
        byte_offset,
        counter,
        sensors,
        forces_n,
    })
}

/// Returns true if the received part can still become a packet: its index size is one that
/// controllers send.
fn may_be_packet(body: &[u8]) -> bool {
    body.first().is_none_or(|size| (1..=4).contains(size))
}

/// Driver of one controller.
struct PapillArray {
    request: Request,
    sensors: usize,
    decoder: Resync<Format>,
}

impl Driver for PapillArray {
    fn shape(&self) -> Shape {
        Shape {
            quantity: Quantity::Force,
            unit: "n",
            fingers: self.sensors,
            taxels: PILLARS,
        }
    }

    fn messages(&self) -> DeviceMessages {
        DeviceMessages {
            start: format!("f{}\n", self.request.rate_hz).into_bytes(),
            once: if self.request.zero {
                b"z\n".to_vec()
            } else {
                Vec::new()
            },
            ..DeviceMessages::default()
        }
    }

    fn receive(&mut self, bytes: &[u8], report: &mut dyn FnMut(Event<'_>)) {
        let sensors = self.sensors;
        self.decoder
            .push(bytes, |packet| report_packet(&packet, sensors, report));
    }

    fn finish(&mut self, report: &mut dyn FnMut(Event<'_>)) {
        let sensors = self.sensors;
        self.decoder
            .finish(|packet| report_packet(&packet, sensors, report));
    }

    fn counts(&self) -> ByteCounts {
        self.decoder.counts()
    }
}

fn report_packet(packet: &Packet, expected: usize, report: &mut dyn FnMut(Event<'_>)) {
    if packet.sensors != expected {
        report(Event::OtherKind(if packet.sensors == 1 {
            "packets of one sensor; pass --sensors 1"
        } else {
            "packets of two sensors; pass --sensors 2"
        }));
        return;
    }
    report(Event::Frame(Frame {
        byte_offset: packet.byte_offset,
        count: Some(packet.counter),
        status: 0,
        temperature_c: None,
        condition: Condition::Normal,
        values: &packet.forces_n[..(3 * PILLARS).saturating_mul(packet.sensors)],
    }));
}
