//! Dynamixel X for the emulator (ROBOTIS e-manual: protocol 2.0, control tables of XL330, XL430 and
//! XM430).

use super::family::{ALL, Error, Family, Request, RequestKind, Table};
use super::shaft::{Shaft, ShaftSetpoints};

/// Dynamixel X.
pub(super) struct Dynamixel;

const HEADER: [u8; 4] = [0xFF, 0xFF, 0xFD, 0x00];
/// Bytes of header, id and length.
const PREFIX: usize = 7;
/// First volatile register. Lower registers are persistent, and locked while torque is on.
const VOLATILE: usize = 64;

const MODEL_NUMBER: usize = 0;
const FIRMWARE: usize = 6;
const ID: usize = 7;
const RETURN_DELAY: usize = 9;
const OPERATING_MODE: usize = 11;
const TORQUE_ENABLE: usize = 64;
const HARDWARE_ERROR: usize = 70;
const GOAL_PWM: usize = 100;
const GOAL_CURRENT: usize = 102;
const PROFILE_VELOCITY: usize = 112;
const GOAL_POSITION: usize = 116;
const PRESENT_CURRENT: usize = 126;
const PRESENT_VELOCITY: usize = 128;
const PRESENT_POSITION: usize = 132;
const PRESENT_VOLTAGE: usize = 144;
const PRESENT_TEMPERATURE: usize = 146;

/// Error numbers of replies.
const DATA_RANGE: Error = 4;
const ACCESS: Error = 7;
const ALERT: u8 = 0x80;

/// Unit of speed, steps/s: 0.229 rpm.
const SPEED_STEP: f64 = 0.229 / 60.0 * 4096.0;
/// Speed without a limit, steps/s.
const SPEED_MAX: f64 = 6000.0;

/// Name, model number, current unit in A.
const MODELS: [(&str, u16, f64); 7] = [
    ("xl330-m077", 1190, 0.001),
    ("xl330-m288", 1200, 0.001),
    ("xc330-m181", 1230, 0.001),
    ("xc330-m288", 1240, 0.001),
    ("xm430-w350", 1020, 0.00269),
    ("xm430-w210", 1030, 0.00269),
    ("xl430-w250", 1060, 0.0),
];

fn current_step_a(table: &Table) -> f64 {
    let number = u16::from_le_bytes([table[MODEL_NUMBER], table[MODEL_NUMBER + 1]]);
    let model = MODELS.iter().find(|(_, known, _)| *known == number);
    model.map_or(0.0, |(_, _, step_a)| *step_a)
}

fn i32_at(table: &Table, address: usize) -> i32 {
    i32::from_le_bytes(std::array::from_fn(|n| table[address + n]))
}

fn i16_at(table: &Table, address: usize) -> i16 {
    i16::from_le_bytes([table[address], table[address + 1]])
}

fn put(table: &mut Table, address: usize, bytes: &[u8]) {
    table[address..address + bytes.len()].copy_from_slice(bytes);
}

/// CRC-16 with polynomial 0x8005, as in the manual.
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

/// Byte stuffing: `FD` follows each `FF FF FD` inside a packet, so that it contains no header.
fn stuffed(body: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(body.len());
    for byte in body {
        out.push(*byte);
        if out.ends_with(&HEADER[..3]) {
            out.push(0xFD);
        }
    }
    out
}

fn unstuffed(body: &[u8]) -> Vec<u8> {
    let mut out: Vec<u8> = Vec::with_capacity(body.len());
    let mut skip = false;
    for byte in body {
        if skip && *byte == 0xFD {
            skip = false;
            continue;
        }
        out.push(*byte);
        skip = out.ends_with(&HEADER[..3]);
    }
    out
}

fn word(bytes: &[u8], at: usize) -> Option<usize> {
    let pair = bytes.get(at..at + 2)?;
    Some(usize::from(u16::from_le_bytes([pair[0], pair[1]])))
}

/// Decodes an instruction with its parameters.
fn decode(instruction: u8, parameters: &[u8]) -> Option<RequestKind> {
    let (address, length) = (word(parameters, 0), word(parameters, 2));
    Some(match instruction {
        0x01 => RequestKind::Ping,
        0x02 => RequestKind::Read {
            address: address?,
            length: length?,
        },
        0x03 => RequestKind::Write {
            address: address?,
            bytes: parameters.get(2..)?.to_vec(),
        },
        0x08 => RequestKind::Reboot,
        0x82 | 0x8A => RequestKind::SyncRead {
            address: address?,
            length: length?,
            ids: parameters.get(4..)?.to_vec(),
            fast: instruction == 0x8A,
        },
        0x83 => RequestKind::SyncWrite {
            address: address?,
            items: parameters
                .get(4..)?
                .chunks_exact(length? + 1)
                .map(|item| (item[0], item[1..].to_vec()))
                .collect(),
        },
        _ => RequestKind::Unknown,
    })
}

impl Family for Dynamixel {
    fn registers(&self, model: &str, id: u8) -> Option<Table> {
        let (_, number, _) = MODELS.iter().find(|(name, ..)| *name == model)?;
        let mut table = [0; 256];
        put(&mut table, MODEL_NUMBER, &number.to_le_bytes());
        (table[FIRMWARE], table[ID]) = (52, id);
        (table[RETURN_DELAY], table[OPERATING_MODE]) = (250, 3);
        self.boot(&mut table);
        Some(table)
    }

    fn boot(&self, table: &mut Table) {
        table[VOLATILE..].fill(0);
        put(table, GOAL_PWM, &885_u16.to_le_bytes());
        put(table, GOAL_CURRENT, &1750_u16.to_le_bytes());
        put(table, PRESENT_VOLTAGE, &50_u16.to_le_bytes());
    }

    fn setpoints(&self, table: &Table) -> ShaftSetpoints {
        let speed = f64::from(i32_at(table, PROFILE_VELOCITY)) * SPEED_STEP;
        ShaftSetpoints {
            torque_on: table[TORQUE_ENABLE] != 0,
            goal_steps: f64::from(i32_at(table, GOAL_POSITION)),
            speed_max: if speed > 0.0 {
                speed.min(SPEED_MAX)
            } else {
                SPEED_MAX
            },
            current_max_a: match current_step_a(table) {
                0.0 => 1.4 * f64::from(i16_at(table, GOAL_PWM)) / 885.0,
                step_a => f64::from(i16_at(table, GOAL_CURRENT)) * step_a,
            },
        }
    }

    fn set_torque(&self, table: &mut Table, on: bool) {
        table[TORQUE_ENABLE] = u8::from(on);
    }

    fn set_errors(&self, table: &mut Table, bits: u8) {
        table[HARDWARE_ERROR] = bits;
    }

    fn write_shaft(&self, shaft: &Shaft, table: &mut Table) {
        let step_a = current_step_a(table);
        let current = if step_a > 0.0 {
            shaft.current_a / step_a
        } else {
            0.0
        };
        put(
            table,
            PRESENT_CURRENT,
            &(current.round() as i16).to_le_bytes(),
        );
        let speed = (shaft.speed_steps_s / SPEED_STEP).round() as i32;
        put(table, PRESENT_VELOCITY, &speed.to_le_bytes());
        let position = shaft.position_steps.round() as i32;
        put(table, PRESENT_POSITION, &position.to_le_bytes());
        table[PRESENT_TEMPERATURE] = shaft.temperature_c as u8;
    }

    fn write(&self, table: &mut Table, address: usize, bytes: &[u8]) -> Result<(), Error> {
        let end = address + bytes.len();
        let locked = address < VOLATILE && table[TORQUE_ENABLE] != 0;
        if end > table.len() || end > PRESENT_CURRENT && address < 168 || locked {
            return Err(ACCESS);
        }
        match bytes.first() {
            Some(2..) if address == TORQUE_ENABLE => return Err(DATA_RANGE),
            Some(1) if address == TORQUE_ENABLE && table[HARDWARE_ERROR] != 0 => {
                return Err(ACCESS);
            }
            _ => {}
        }
        put(table, address, bytes);
        Ok(())
    }

    fn status(&self, table: &Table) -> u8 {
        if table[HARDWARE_ERROR] == 0 { 0 } else { ALERT }
    }

    fn ping(&self, table: &Table) -> Vec<u8> {
        vec![
            table[MODEL_NUMBER],
            table[MODEL_NUMBER + 1],
            table[FIRMWARE],
        ]
    }

    fn return_delay_us(&self, table: &Table) -> u64 {
        2 * u64::from(table[RETURN_DELAY])
    }

    fn take_request(&self, bytes: &mut Vec<u8>) -> Option<Request> {
        loop {
            let begin = bytes.windows(4).position(|four| four == HEADER);
            let keep = begin.unwrap_or(bytes.len().saturating_sub(3));
            bytes.drain(..keep);
            let length = word(bytes, 5)?;
            if length < 3 {
                bytes.drain(..4);
                continue;
            }
            let end = PREFIX + length;
            if bytes.len() < end {
                return None;
            }
            let packet: Vec<u8> = bytes.drain(..end).collect();
            let sum = u16::from_le_bytes([packet[end - 2], packet[end - 1]]);
            if crc(&packet[..end - 2]) != sum {
                continue;
            }
            let parameters = unstuffed(&packet[PREFIX + 1..end - 2]);
            return Some(Request {
                id: packet[4],
                kind: decode(packet[PREFIX], &parameters).unwrap_or(RequestKind::Unknown),
            });
        }
    }

    fn answer(&self, id: u8, status: u8, parameters: &[u8]) -> Vec<u8> {
        let mut body = vec![0x55, status];
        body.extend(parameters);
        let body = stuffed(&body);
        let mut packet = HEADER.to_vec();
        packet.push(id);
        packet.extend((body.len() as u16 + 2).to_le_bytes());
        packet.extend(body);
        packet.extend(crc(&packet).to_le_bytes());
        packet
    }

    /// Returns one packet with the broadcast id: for each servo its status, id, registers, and the
    /// checksum of all previous bytes.
    fn answer_together(&self, asked: usize, blocks: &[(u8, u8, Vec<u8>)]) -> Vec<u8> {
        let Some((.., first)) = blocks.first() else {
            return Vec::new();
        };
        let length = asked * (first.len() + 4) + 1;
        // Servos cannot reply with a packet that is longer than its length field permits.
        let Ok(length) = u16::try_from(length) else {
            return Vec::new();
        };
        let mut packet = HEADER.to_vec();
        packet.push(ALL);
        packet.extend(length.to_le_bytes());
        packet.push(0x55);
        for (id, status, bytes) in blocks {
            packet.extend([*status, *id]);
            packet.extend(bytes);
            packet.extend(crc(&packet).to_le_bytes());
        }
        packet
    }
}
