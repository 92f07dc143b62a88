//! Servo buses: replies to the drivers, and requests to the emulated servos.
//!
//! Replies are those of the emulated servos, changed as the input says, with or without a repaired
//! checksum.

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::time::Duration;

use atas_robots::drivers::protocol::Protocol;
use atas_robots::drivers::wire::Wire;
use atas_robots::drivers::{Driver, Servo, find};
use atas_robots::emulator::{PlannedServo, Responder};
use serialport::{ClearBuffer, DataBits, FlowControl, Parity, Result, SerialPort, StopBits};

use crate::input::Input;
use crate::target::Target;

/// Targets of this file.
pub(crate) const TARGETS: [Target; 4] = [
    Target::new("servo-dynamixel", dynamixel_replies, reply_seeds),
    Target::new("servo-feetech", feetech_replies, reply_seeds),
    Target::new("emulator-dynamixel", dynamixel_requests, dynamixel_seeds),
    Target::new("emulator-feetech", feetech_requests, feetech_seeds),
];

/// Ids of the emulated servos.
const IDS: [u8; 3] = [1, 2, 7];

fn model(family: &str) -> &'static str {
    if family == "feetech" {
        "sts3215"
    } else {
        "xl330-m288"
    }
}

fn responder(family: &str) -> Responder {
    let servos = IDS.map(|id| PlannedServo {
        id,
        model: model(family).to_owned(),
        position: f64::from(id) * 0.3,
    });
    Responder::new(family, &servos).expect("a known family")
}

/// Port to emulated servos that changes their replies.
struct ChangingPort {
    servos: Responder,
    protocol: Protocol,
    /// Instructions for one reply each.
    changes: VecDeque<Vec<u8>>,
    received: VecDeque<u8>,
}

impl Read for ChangingPort {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.received.read(buffer)? {
            0 => Err(io::ErrorKind::TimedOut.into()),
            count => Ok(count),
        }
    }
}

impl Write for ChangingPort {
    fn write(&mut self, request: &[u8]) -> io::Result<usize> {
        let mut reply = self.servos.respond(request);
        if let Some(change) = self.changes.pop_front() {
            let mut input = Input::new(&change);
            let kind = input.byte();
            match kind % 8 {
                0..=4 => input.patch_bytes(&mut reply),
                5 => reply.extend(input.bytes(64)),
                6 => reply = [input.bytes(64), &reply].concat(),
                _ => reply.truncate(usize::from(input.byte())),
            }
            if kind >= 64 {
                repair(self.protocol, &mut reply);
            }
        }
        self.received.extend(reply);
        Ok(request.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Repairs the checksums of all packets.
fn repair(protocol: Protocol, bytes: &mut [u8]) {
    for begin in 0..bytes.len() {
        let packet = &mut bytes[begin..];
        match (protocol, &*packet) {
            (Protocol::One, [0xFF, 0xFF, _, length, ..]) if *length >= 2 => {
                let end = 3 + usize::from(*length);
                if let Some([_, _, covered @ .., sum]) = packet.get_mut(..=end) {
                    *sum = !covered
                        .iter()
                        .fold(0_u8, |sum, &byte| sum.wrapping_add(byte));
                }
            }
            (Protocol::Two, [0xFF, 0xFF, 0xFD, 0, _, low, high, ..]) => {
                let end = 7 + usize::from(u16::from_le_bytes([*low, *high]));
                if let Some([covered @ .., low, high]) = packet.get_mut(..end) {
                    [*low, *high] = crc(covered).to_le_bytes();
                }
            }
            _ => {}
        }
    }
}

/// CRC-16 of protocol 2.0.
fn crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0, |sum: u16, byte| {
        (0..8).fold(sum ^ u16::from(*byte) << 8, |sum, _| {
            if sum & 0x8000 == 0 {
                sum << 1
            } else {
                sum << 1 ^ 0x8005
            }
        })
    })
}

macro_rules! settings {
    ($($get:ident: $value:ty = $result:expr),*; $($set:ident: $new:ty),*; $($read:ident),*) => {
        $(fn $get(&self) -> Result<$value> {
            Ok($result)
        })*
        $(fn $set(&mut self, _value: $new) -> Result<()> {
            Ok(())
        })*
        $(fn $read(&mut self) -> Result<bool> {
            Ok(false)
        })*
    };
}

impl SerialPort for ChangingPort {
    fn name(&self) -> Option<String> {
        None
    }

    fn timeout(&self) -> Duration {
        Duration::from_millis(1)
    }

    fn clear(&self, _buffer: ClearBuffer) -> Result<()> {
        Ok(())
    }

    fn try_clone(&self) -> Result<Box<dyn SerialPort>> {
        Err(io::Error::from(io::ErrorKind::Unsupported).into())
    }

    settings! {
        baud_rate: u32 = 1_000_000, data_bits: DataBits = DataBits::Eight,
            flow_control: FlowControl = FlowControl::None, parity: Parity = Parity::None,
            stop_bits: StopBits = StopBits::One, bytes_to_write: u32 = 0, bytes_to_read: u32 = 0,
            set_break: () = (), clear_break: () = ();
        set_baud_rate: u32, set_data_bits: DataBits, set_flow_control: FlowControl,
            set_parity: Parity, set_stop_bits: StopBits, set_timeout: Duration,
            write_request_to_send: bool, write_data_terminal_ready: bool;
        read_clear_to_send, read_data_set_ready, read_ring_indicator, read_carrier_detect
    }
}

fn dynamixel_replies(bytes: &[u8]) {
    replies("dynamixel", bytes);
}

fn feetech_replies(bytes: &[u8]) {
    replies("feetech", bytes);
}

fn replies(family: &str, bytes: &[u8]) {
    let driver = find(family).expect("a known family");
    let mut input = Input::new(bytes);
    let choice = input.byte();
    let mut changes = VecDeque::new();
    while !input.is_empty() {
        let length = usize::from(input.byte());
        changes.push_back(input.bytes(length).to_vec());
    }
    let port = ChangingPort {
        servos: responder(family),
        protocol: driver.protocol(),
        changes,
        received: VecDeque::new(),
    };
    let mut wire = Wire::with_port(Box::new(port), driver.protocol());
    let _exchanged = exchange(driver, &mut wire, choice);
    let _echoes = wire.echoes();
}

/// One exchange of every kind; an error ends it, as in the program.
fn exchange(
    driver: &dyn Driver,
    wire: &mut Wire,
    choice: u8,
) -> core::result::Result<(), Box<dyn std::error::Error>> {
    let model = driver.model(model(driver.name())).ok_or("no model")?;
    let servos = IDS.map(|id| Servo {
        id,
        model,
        limit: 0.5,
        speed_max_rad_s: 2.0,
    });
    let [first, ..] = &servos;
    let mut readings = Vec::new();
    let steps = [
        |driver: &dyn Driver, wire: &mut Wire, servos: &[Servo], _: &mut Vec<_>| {
            driver.choose_reading(wire, servos)
        },
        |driver: &dyn Driver, wire: &mut Wire, servos: &[Servo], readings: &mut Vec<_>| {
            driver.read(wire, servos, readings)
        },
    ];
    if choice & 1 == 0 {
        let _ids = wire.scan()?;
    }
    if choice & 2 == 0 {
        let _number = driver.model_number(wire, first.id)?;
        let _state = driver.state(wire, first)?;
        driver.configure(wire, first)?;
        driver.set_torque(wire, first.id, true)?;
        let _health = driver.health(wire, first.id)?;
    }
    for step in steps {
        step(driver, wire, &servos, &mut readings)?;
    }
    driver.write_goals(wire, &servos, &[0.1, 0.2, 0.3])?;
    let position = driver.position(wire, first)?;
    assert!(position.is_finite());
    for reading in readings {
        let values = [reading.position, reading.velocity, reading.current_a];
        assert!(values.iter().all(|value| value.is_finite()));
    }
    Ok(())
}

fn reply_seeds() -> Vec<Vec<u8>> {
    let change = |kind: u8, place: u8| vec![12, kind, 1, 1, place, 0, 64, 9, 1, 1, 1, 1, 1];
    let mut seeds = vec![vec![0], vec![1], vec![2], vec![3]];
    for kind in [0, 5, 6, 7, 64, 69, 70, 71] {
        for place in 0..12 {
            seeds.push([vec![place % 4], change(kind, place).repeat(5)].concat());
        }
    }
    seeds
}

fn dynamixel_requests(bytes: &[u8]) {
    requests("dynamixel", Protocol::Two, bytes);
}

fn feetech_requests(bytes: &[u8]) {
    requests("feetech", Protocol::One, bytes);
}

fn requests(family: &str, protocol: Protocol, bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let options = input.byte();
    let mut stream = input.rest().to_vec();
    if options & 1 == 1 {
        repair(protocol, &mut stream);
    }
    let mut servos = responder(family);
    let chunk = usize::from(options >> 1).max(1);
    for piece in stream.chunks(chunk) {
        let _replies = servos.respond(piece);
    }
}

/// Requests of protocol 2.0, from the manual: ping, read, write, sync read, fast sync read, sync
/// write, reboot.
fn dynamixel_seeds() -> Vec<Vec<u8>> {
    let packet = |id: u8, body: &[u8]| {
        let mut packet = vec![0xFF, 0xFF, 0xFD, 0, id];
        packet.extend((body.len() as u16 + 2).to_le_bytes());
        packet.extend(body);
        packet.extend([0, 0]);
        repair(Protocol::Two, &mut packet);
        packet
    };
    let requests = [
        packet(0xFE, &[1]),
        packet(1, &[2, 132, 0, 4, 0]),
        packet(1, &[3, 64, 0, 1]),
        packet(2, &[3, 116, 0, 0, 2, 0, 0]),
        packet(0xFE, &[0x82, 126, 0, 10, 0, 1, 2, 7]),
        packet(0xFE, &[0x8A, 126, 0, 10, 0, 1, 2, 7]),
        packet(0xFE, &[0x83, 116, 0, 4, 0, 1, 9, 9, 0, 0, 2, 9, 9, 0, 0]),
        packet(1, &[8]),
    ];
    with_options(&requests)
}

/// The requests of protocol 1.0.
fn feetech_seeds() -> Vec<Vec<u8>> {
    let packet = |id: u8, body: &[u8]| {
        let mut packet = vec![0xFF, 0xFF, id, body.len() as u8 + 1];
        packet.extend(body);
        packet.push(0);
        repair(Protocol::One, &mut packet);
        packet
    };
    let requests = [
        packet(0xFE, &[1]),
        packet(1, &[2, 56, 2]),
        packet(1, &[3, 40, 1]),
        packet(2, &[3, 42, 0, 2]),
        packet(0xFE, &[0x82, 56, 15, 1, 2, 7]),
        packet(0xFE, &[0x83, 42, 2, 1, 9, 9, 2, 9, 9]),
        packet(1, &[8]),
    ];
    with_options(&requests)
}

fn with_options(requests: &[Vec<u8>]) -> Vec<Vec<u8>> {
    let alone = requests.iter().cloned().chain([requests.concat()]);
    alone
        .flat_map(|request| [0xFE, 0xFF, 7].map(|options| [&[options][..], &request].concat()))
        .collect()
}
