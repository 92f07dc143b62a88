//! Feetech STS for the emulator (Feetech: communication protocol, STS3215 memory table).

use super::family::{Error, Family, Request, RequestKind, Table};
use super::shaft::{Shaft, ShaftSetpoints};

/// Feetech STS.
pub(super) struct Feetech;

const MODEL_NUMBER: usize = 3;
const ID: usize = 5;
const RETURN_DELAY: usize = 7;
const TORQUE_ENABLE: usize = 40;
const GOAL_POSITION: usize = 42;
const GOAL_SPEED: usize = 46;
const TORQUE_LIMIT: usize = 48;
const LOCK: usize = 55;
const PRESENT_POSITION: usize = 56;
const PRESENT_SPEED: usize = 58;
const PRESENT_VOLTAGE: usize = 62;
const PRESENT_TEMPERATURE: usize = 63;
const ALARMS: usize = 65;
const PRESENT_CURRENT: usize = 69;
/// First volatile register. Lower registers are persistent, and locked while the lock is closed.
const VOLATILE: usize = 40;

const STS3215: u16 = 777;
/// Speed without a limit, steps/s, and current at full torque, A.
const SPEED_MAX: f64 = 3400.0;
const CURRENT_MAX_A: f64 = 2.7;
const CURRENT_STEP_A: f64 = 0.0065;

fn word(table: &Table, address: usize) -> u16 {
    u16::from_le_bytes([table[address], table[address + 1]])
}

/// Writes a value as sign and magnitude.
fn put(table: &mut Table, address: usize, value: f64) {
    let magnitude = value.abs().round().min(32_767.0) as u16;
    let sign = if value < 0.0 { 0x8000 } else { 0 };
    table[address..address + 2].copy_from_slice(&(magnitude | sign).to_le_bytes());
}

fn checksum(bytes: &[u8]) -> u8 {
    !bytes.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte))
}

/// Decodes an instruction with its parameters.
fn decode(instruction: u8, parameters: &[u8]) -> Option<RequestKind> {
    let number = |at: usize| parameters.get(at).map(|byte| usize::from(*byte));
    Some(match instruction {
        0x01 => RequestKind::Ping,
        0x02 => RequestKind::Read {
            address: number(0)?,
            length: number(1)?,
        },
        0x03 => RequestKind::Write {
            address: number(0)?,
            bytes: parameters.get(1..)?.to_vec(),
        },
        0x08 => RequestKind::Reboot,
        0x82 => RequestKind::SyncRead {
            address: number(0)?,
            length: number(1)?,
            ids: parameters.get(2..)?.to_vec(),
            fast: false,
        },
        0x83 => RequestKind::SyncWrite {
            address: number(0)?,
            items: parameters
                .get(2..)?
                .chunks_exact(number(1)? + 1)
                .map(|item| (item[0], item[1..].to_vec()))
                .collect(),
        },
        _ => RequestKind::Unknown,
    })
}

impl Family for Feetech {
    fn registers(&self, model: &str, id: u8) -> Option<Table> {
        if model != "sts3215" {
            return None;
        }
        let mut table = [0; 256];
        table[MODEL_NUMBER..MODEL_NUMBER + 2].copy_from_slice(&STS3215.to_le_bytes());
        (table[ID], table[RETURN_DELAY]) = (id, 250);
        self.boot(&mut table);
        Some(table)
    }

    fn boot(&self, table: &mut Table) {
        table[VOLATILE..].fill(0);
        table[TORQUE_LIMIT..TORQUE_LIMIT + 2].copy_from_slice(&1000_u16.to_le_bytes());
        (table[LOCK], table[PRESENT_VOLTAGE]) = (1, 74);
    }

    fn setpoints(&self, table: &Table) -> ShaftSetpoints {
        let speed = f64::from(word(table, GOAL_SPEED));
        ShaftSetpoints {
            torque_on: table[TORQUE_ENABLE] != 0,
            goal_steps: f64::from(word(table, GOAL_POSITION)),
            speed_max: if speed > 0.0 {
                speed.min(SPEED_MAX)
            } else {
                SPEED_MAX
            },
            current_max_a: CURRENT_MAX_A * f64::from(word(table, TORQUE_LIMIT)) / 1000.0,
        }
    }

    fn set_torque(&self, table: &mut Table, on: bool) {
        table[TORQUE_ENABLE] = u8::from(on);
    }

    fn set_errors(&self, table: &mut Table, bits: u8) {
        table[ALARMS] = bits;
    }

    fn write_shaft(&self, shaft: &Shaft, table: &mut Table) {
        put(table, PRESENT_POSITION, shaft.position_steps);
        put(table, PRESENT_SPEED, shaft.speed_steps_s);
        put(table, PRESENT_CURRENT, shaft.current_a / CURRENT_STEP_A);
        table[PRESENT_TEMPERATURE] = shaft.temperature_c as u8;
    }

    /// A write to a locked register has no effect and no error.
    fn write(&self, table: &mut Table, address: usize, bytes: &[u8]) -> Result<(), Error> {
        let end = (address + bytes.len()).min(table.len());
        let (locked, measured) = (
            address < VOLATILE && table[LOCK] != 0,
            end > PRESENT_POSITION,
        );
        if address < end && !locked && !measured {
            table[address..end].copy_from_slice(&bytes[..end - address]);
        }
        Ok(())
    }

    fn status(&self, table: &Table) -> u8 {
        table[ALARMS]
    }

    fn ping(&self, _table: &Table) -> Vec<u8> {
        Vec::new()
    }

    fn return_delay_us(&self, table: &Table) -> u64 {
        2 * u64::from(table[RETURN_DELAY])
    }

    fn take_request(&self, bytes: &mut Vec<u8>) -> Option<Request> {
        loop {
            let begin = bytes.windows(2).position(|two| two == [0xFF, 0xFF]);
            let keep = begin.unwrap_or(bytes.len().saturating_sub(1));
            bytes.drain(..keep);
            let length = usize::from(*bytes.get(3)?);
            if length < 2 || bytes[2] == 0xFF {
                bytes.drain(..1);
                continue;
            }
            let end = 4 + length;
            if bytes.len() < end {
                return None;
            }
            if checksum(&bytes[2..end - 1]) != bytes[end - 1] {
                bytes.drain(..2);
                continue;
            }
            let packet: Vec<u8> = bytes.drain(..end).collect();
            return Some(Request {
                id: packet[2],
                kind: decode(packet[4], &packet[5..end - 1]).unwrap_or(RequestKind::Unknown),
            });
        }
    }

    fn answer(&self, id: u8, status: u8, parameters: &[u8]) -> Vec<u8> {
        // A servo cannot reply with a packet that is longer than its length field permits.
        let Ok(length) = u8::try_from(parameters.len() + 2) else {
            return Vec::new();
        };
        let mut packet = vec![0xFF, 0xFF, id, length, status];
        packet.extend(parameters);
        packet.push(checksum(&packet[2..]));
        packet
    }

    /// These servos have no fast read: each replies separately.
    fn answer_together(&self, _asked: usize, blocks: &[(u8, u8, Vec<u8>)]) -> Vec<u8> {
        let answers = blocks.iter();
        answers
            .flat_map(|(id, status, bytes)| self.answer(*id, *status, bytes))
            .collect()
    }
}
