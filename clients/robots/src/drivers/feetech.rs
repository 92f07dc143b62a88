//! Feetech STS servos, protocol 1.0 with little-endian registers (Feetech, "STS3215 memory table").
//!
//! Signed values are sign and magnitude. The servo measures but does not regulate its current; its
//! torque is limited. Persistent registers are locked while the lock is closed.

use core::f64::consts::TAU;

use super::driver::{Driver, Health, LimitKind, Model, Reading, Servo, State};
use super::protocol::Protocol;
use super::wire::{Wire, WireError};

/// Feetech STS.
#[derive(Clone, Copy, Debug)]
pub struct Feetech;

/// Encoder steps per turn; speeds are in steps per second.
const STEPS: f64 = 4096.0;
/// Unit of the torque limit, %.
const TORQUE_STEP_PERCENT: f64 = 0.1;

const MODEL_NUMBER: u8 = 3;
/// Delay before a reply, in 2 µs.
const RETURN_DELAY: u8 = 7;
const OPERATING_MODE: u8 = 33;
const TORQUE_ENABLE: u8 = 40;
const GOAL_POSITION: u8 = 42;
const GOAL_SPEED: u8 = 46;
const TORQUE_LIMIT: u8 = 48;
const LOCK: u8 = 55;
/// Position (2 bytes), speed (2), load (2), voltage, temperature, a byte, alarms, moving, two
/// bytes, current (2).
const PRESENT_POSITION: u8 = 56;
const READ_BYTES: u8 = 15;
const PRESENT_TEMPERATURE: u8 = 63;
const ALARMS: u8 = 65;

const MODE_POSITION: u8 = 0;

/// Bits of the alarm register and of a reply's status.
const ERROR_TEXTS: [(u8, &str); 5] = [
    (0, "supply voltage out of range"),
    (1, "encoder failure"),
    (2, "overheated"),
    (3, "overcurrent"),
    (5, "overload"),
];

const MODELS: [Model; 1] = [Model {
    name: "sts3215",
    number: 777,
    current_step_a: Some(0.0065),
    limit: LimitKind::Torque,
    limit_max: 100.0,
    multi_turn: false,
    temperature_max_c: 70.0,
}];

fn steps(goal_rad: f64) -> u16 {
    (goal_rad * STEPS / TAU).round().clamp(0.0, STEPS - 1.0) as u16
}

/// Decodes sign and magnitude, sign in the highest bit.
fn signed(bytes: &[u8]) -> f64 {
    let raw = bytes.try_into().map_or(0, u16::from_le_bytes);
    let magnitude = f64::from(raw & 0x7FFF);
    if raw & 0x8000 == 0 {
        magnitude
    } else {
        -magnitude
    }
}

fn angle_rad(bytes: &[u8]) -> f64 {
    signed(bytes) * TAU / STEPS
}

impl Driver for Feetech {
    fn name(&self) -> &'static str {
        "feetech"
    }

    fn about(&self) -> &'static str {
        "Feetech STS, protocol 1.0"
    }

    fn protocol(&self) -> Protocol {
        Protocol::One
    }

    fn bauds(&self) -> &'static [u32] {
        &[1_000_000, 500_000, 115_200, 57_600]
    }

    fn models(&self) -> &'static [Model] {
        &MODELS
    }

    fn model_number(&self, wire: &mut Wire, id: u8) -> Result<u16, WireError> {
        let bytes = wire.read(id, MODEL_NUMBER, 2)?;
        Ok(u16::from_le_bytes([bytes[0], bytes[1]]))
    }

    fn state(&self, wire: &mut Wire, servo: &Servo) -> Result<State, WireError> {
        let id = servo.id;
        if wire.read(id, TORQUE_ENABLE, 1)? == [0] {
            return Ok(State::TorqueOff);
        }
        let found = wire.read(id, OPERATING_MODE, 1)?[0];
        if found != MODE_POSITION {
            return Err(WireError::WrongMode {
                id,
                found,
                needed: MODE_POSITION,
            });
        }
        Ok(State::Holding(angle_rad(&wire.read(
            id,
            GOAL_POSITION,
            2,
        )?)))
    }

    fn configure(&self, wire: &mut Wire, servo: &Servo) -> Result<(), WireError> {
        wire.write(servo.id, LOCK, &[0])?;
        // Both registers are in memory with limited write cycles, so they are written only on
        // change.
        for (register, value) in [(RETURN_DELAY, 0), (OPERATING_MODE, MODE_POSITION)] {
            if wire.read(servo.id, register, 1)? != [value] {
                wire.write(servo.id, register, &[value])?;
            }
        }
        wire.write(servo.id, LOCK, &[1])?;
        self.limit(wire, servo)
    }

    fn limit(&self, wire: &mut Wire, servo: &Servo) -> Result<(), WireError> {
        // Rounded down, so that the limit is never exceeded. A speed of 0 would mean "no limit".
        let limit = (servo.limit / TORQUE_STEP_PERCENT).floor() as u16;
        wire.write(servo.id, TORQUE_LIMIT, &limit.to_le_bytes())?;
        let speed = (servo.speed_max_rad_s * STEPS / TAU)
            .floor()
            .clamp(1.0, 32_767.0) as u16;
        wire.write(servo.id, GOAL_SPEED, &speed.to_le_bytes())
    }

    fn set_torque(&self, wire: &mut Wire, id: u8, on: bool) -> Result<(), WireError> {
        wire.write(id, TORQUE_ENABLE, &[u8::from(on)])
    }

    fn read(
        &self,
        wire: &mut Wire,
        servos: &[Servo],
        out: &mut Vec<Reading>,
    ) -> Result<(), WireError> {
        let ids: Vec<u8> = servos.iter().map(|servo| servo.id).collect();
        let answers = wire.read_all(&ids, PRESENT_POSITION, READ_BYTES)?;
        out.clear();
        out.extend(servos.iter().zip(answers).map(|(servo, (bytes, status))| {
            let step_a = servo.model.current_step_a.unwrap_or(0.0);
            Reading {
                position: angle_rad(&bytes[..2]),
                velocity: signed(&bytes[2..4]) * TAU / STEPS,
                current_a: signed(&bytes[13..15]) * step_a,
                alert: status != 0,
            }
        }));
        Ok(())
    }

    fn write_goals(
        &self,
        wire: &mut Wire,
        servos: &[Servo],
        goals_rad: &[f64],
    ) -> Result<(), WireError> {
        let ids: Vec<u8> = servos.iter().map(|servo| servo.id).collect();
        let goals = goals_rad
            .iter()
            .map(|&goal_rad| steps(goal_rad).to_le_bytes().to_vec());
        wire.write_all(&ids, GOAL_POSITION, &goals.collect::<Vec<_>>())
    }

    fn rounded(&self, goal_rad: f64) -> f64 {
        f64::from(steps(goal_rad)) * TAU / STEPS
    }

    fn health(&self, wire: &mut Wire, id: u8) -> Result<Health, WireError> {
        let bytes = wire.read(id, TORQUE_ENABLE, ALARMS - TORQUE_ENABLE + 1)?;
        let alarms = bytes[usize::from(ALARMS - TORQUE_ENABLE)];
        let complaints = ERROR_TEXTS.iter().filter(|(bit, _)| alarms >> bit & 1 == 1);
        Ok(Health {
            torque_on: bytes[0] != 0,
            temperature_c: f64::from(bytes[usize::from(PRESENT_TEMPERATURE - TORQUE_ENABLE)]),
            errors: complaints.map(|(_, words)| *words).collect(),
        })
    }
}
