//! ATI Net F/T six-axis sensors: Raw Data Transfer over UDP, port 49152, up to 7 kHz (big-endian).
//!
//! | message | bytes | layout |
//! |---|---|---|
//! | request, to the box | 8 | `12 34`, command (`u16`), number of records (`u32`, 0 for endless) |
//! | record | 36 | `rdt_sequence`, `ft_sequence`, status (`u32`), Fx … Tz (`i32`, counts) |
//!
//! Commands: 0 stop, 2 real-time stream, 3 buffered stream (several records per datagram), `0x42`
//! set the bias. Status 0 means no error. `0x8001_0000` alone is a latched threshold monitor, a
//! warning. Bit 31 with any other bit means invalid values. The box's page
//! `http://HOST/netftapi2.xml` lists counts per newton as `cfgcpf`. A datagram whose length is not
//! a multiple of 36 is junk. A request may be lost and a box may restart, so the driver repeats its
//! request during silence. Source: the vendor's manual as public drivers implement it.

use clap::{ArgMatches, Args};

use crate::reading::{ByteCounts, Condition, Frame, Quantity, Shape};
use crate::wire::{DeviceMessages, Driver, Event, Interface, Request, SensorType, Zero};

/// Entry in the list of sensors.
pub const TYPE: SensorType = SensorType {
    name: "netft",
    about: "ATI Net F/T six-axis force/torque sensor over UDP",
    wire: "UDP port 49152, big-endian records of 36 bytes",
    interface: Interface::Udp { port: 49_152 },
    taxels: 1,
    rate_hz: "7000",
    newtons_per_unit: None,
    axes: "-z,x,y",
    zero: Zero::Device,
    example: "--device 192.168.1.1 --hand left --newtons-per-count 1/1000000,1/1000000,1/1000000",
    notes: "The page http://HOST/netftapi2.xml lists counts per newton (cfgcpf); pass their \
        reciprocal.",
    options: <Options as Args>::augment_args,
    driver: make,
};

/// Bytes of a record.
const RECORD: usize = 36;
/// Status of a latched monitor condition alone (vendor's manual).
const LATCHED_MONITOR: u32 = 0x8001_0000;

#[derive(Debug, Args)]
struct Options {}

fn make(_matches: &ArgMatches, request: &Request) -> Result<Box<dyn Driver>, String> {
    Ok(Box::new(NetFt {
        zero: request.zero,
        counts: ByteCounts::default(),
    }))
}

/// Returns a request for endless records.
fn request(command: u16) -> [u8; 8] {
    let [high, low] = command.to_be_bytes();
    [0x12, 0x34, high, low, 0, 0, 0, 0]
}

/// Driver of one box.
struct NetFt {
    zero: bool,
    counts: ByteCounts,
}

impl Driver for NetFt {
    fn shape(&self) -> Shape {
        Shape {
            quantity: Quantity::Wrench,
            unit: "counts",
            fingers: 1,
            taxels: 1,
        }
    }

    fn messages(&self) -> DeviceMessages {
        DeviceMessages {
            start: request(2).to_vec(),
            once: if self.zero {
                request(0x42).to_vec()
            } else {
                Vec::new()
            },
            repeat_start: true,
            stop: request(0).to_vec(),
            ..DeviceMessages::default()
        }
    }

    fn receive(&mut self, bytes: &[u8], report: &mut dyn FnMut(Event<'_>)) {
        let byte_offset = self.counts.received;
        let length = bytes.len() as u64;
        self.counts.received += length;
        if bytes.is_empty() || !bytes.len().is_multiple_of(RECORD) {
            self.counts.junk += length;
            self.counts.checksum_failures += 1;
            return;
        }
        self.counts.data += length;
        for (index, record) in bytes.chunks_exact(RECORD).enumerate() {
            self.counts.frames += 1;
            report_record(record, byte_offset + (index * RECORD) as u64, report);
        }
    }

    fn counts(&self) -> ByteCounts {
        self.counts
    }
}

fn report_record(record: &[u8], byte_offset: u64, report: &mut dyn FnMut(Event<'_>)) {
    let (words, _) = record.as_chunks::<4>();
    let word = |index: usize| u32::from_be_bytes(words[index]);
    let values: [f64; 6] = core::array::from_fn(|axis| f64::from(word(3 + axis).cast_signed()));
    let status = word(2);
    report(Event::Frame(Frame {
        byte_offset,
        count: Some(word(0)),
        status,
        temperature_c: None,
        condition: match status {
            0 => Condition::Normal,
            LATCHED_MONITOR => Condition::Degraded,
            bits if bits >> 31 == 0 => Condition::Degraded,
            _ => Condition::Failed,
        },
        values: &values,
    }));
}
