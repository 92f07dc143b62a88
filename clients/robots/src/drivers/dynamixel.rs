//! Dynamixel X servos, protocol 2.0 (ROBOTIS e-manual, "Control Table" of each model).
//!
//! Models with current regulation run in current-based position mode: the servo tracks its goal
//! within its current limit. The XL430 has no current regulation; its motor voltage is limited
//! instead.

use core::f64::consts::TAU;

use super::driver::{Driver, Health, LimitKind, Model, Reading, Servo, State};
use super::protocol::Protocol;
use super::wire::{Wire, WireError};

/// Dynamixel X.
#[derive(Clone, Copy, Debug)]
pub struct Dynamixel;

/// Encoder steps per turn.
const STEPS: f64 = 4096.0;
/// Unit of speed, rad/s: 0.229 rpm.
const SPEED_STEP_RAD_S: f64 = 0.229 * TAU / 60.0;
/// Unit of the PWM goal, %: 885 is 100 %.
const PWM_STEP_PERCENT: f64 = 100.0 / 885.0;

const MODEL_NUMBER: u8 = 0;
/// Delay before a reply, in 2 µs. The factory value 250 takes longer than the reply itself.
const RETURN_DELAY: u8 = 9;
const OPERATING_MODE: u8 = 11;
const TORQUE_ENABLE: u8 = 64;
const HARDWARE_ERROR: u8 = 70;
const GOAL_PWM: u8 = 100;
const GOAL_CURRENT: u8 = 102;
const PROFILE_VELOCITY: u8 = 112;
const GOAL_POSITION: u8 = 116;
/// Current (2 bytes), speed (4) and position (4) are consecutive.
const PRESENT_CURRENT: u8 = 126;
const READ_BYTES: u8 = 10;
const PRESENT_TEMPERATURE: u8 = 146;

const MODE_POSITION: u8 = 3;
const MODE_CURRENT_BASED_POSITION: u8 = 5;
/// Status bit of a reply: hardware error.
const ALERT: u8 = 0x80;

/// Bits of the hardware error register.
const ERROR_TEXTS: [(u8, &str); 5] = [
    (0, "supply voltage out of range"),
    (2, "overheated"),
    (3, "encoder failure"),
    (4, "motor electronics failure"),
    (5, "overload"),
];

const fn by_current(
    name: &'static str,
    number: u16,
    step_a: f64,
    limit_a: f64,
    hot_c: f64,
) -> Model {
    Model {
        name,
        number,
        current_step_a: Some(step_a),
        limit: LimitKind::Current,
        limit_max: limit_a,
        multi_turn: true,
        temperature_max_c: hot_c,
    }
}

const MODELS: [Model; 7] = [
    by_current("xl330-m077", 1190, 0.001, 1.75, 70.0),
    by_current("xl330-m288", 1200, 0.001, 1.75, 70.0),
    by_current("xc330-m181", 1230, 0.001, 1.75, 70.0),
    by_current("xc330-m288", 1240, 0.001, 1.75, 70.0),
    by_current("xm430-w350", 1020, 0.00269, 3.2, 80.0),
    by_current("xm430-w210", 1030, 0.00269, 3.2, 80.0),
    Model {
        name: "xl430-w250",
        number: 1060,
        current_step_a: None,
        limit: LimitKind::Torque,
        limit_max: 100.0,
        multi_turn: false,
        temperature_max_c: 72.0,
    },
];

fn mode_of(model: &Model) -> u8 {
    match model.limit {
        LimitKind::Current => MODE_CURRENT_BASED_POSITION,
        LimitKind::Torque => MODE_POSITION,
    }
}

fn steps(goal_rad: f64) -> i32 {
    (goal_rad * STEPS / TAU).round() as i32
}

fn angle_rad(bytes: &[u8]) -> f64 {
    f64::from(i32_of(bytes)) * TAU / STEPS
}

fn i32_of(bytes: &[u8]) -> i32 {
    bytes.try_into().map_or(0, i32::from_le_bytes)
}

fn i16_of(bytes: &[u8]) -> i16 {
    bytes.try_into().map_or(0, i16::from_le_bytes)
}

impl Driver for Dynamixel {
    fn name(&self) -> &'static str {
        "dynamixel"
    }

    fn about(&self) -> &'static str {
        "ROBOTIS Dynamixel X, protocol 2.0"
    }

    fn protocol(&self) -> Protocol {
        Protocol::Two
    }

    fn bauds(&self) -> &'static [u32] {
        &[57_600, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 115_200]
    }

    fn models(&self) -> &'static [Model] {
        &MODELS
    }

    fn model_number(&self, wire: &mut Wire, id: u8) -> Result<u16, WireError> {
        let bytes = wire.read(id, MODEL_NUMBER, 2)?;
        Ok(i16_of(&bytes).cast_unsigned())
    }

    /// Fast sync read returns one packet for all servos. Older firmware (XL330 before 46) does not
    /// support it.
    fn choose_reading(&self, wire: &mut Wire, servos: &[Servo]) -> Result<(), WireError> {
        let read = |wire: &mut Wire| self.read(wire, servos, &mut Vec::new());
        wire.set_fast(true);
        if wire.repeat(read).is_ok() {
            return Ok(());
        }
        wire.set_fast(false);
        wire.repeat(read)
    }

    fn state(&self, wire: &mut Wire, servo: &Servo) -> Result<State, WireError> {
        let id = servo.id;
        if wire.read(id, TORQUE_ENABLE, 1)? == [0] {
            return Ok(State::TorqueOff);
        }
        let (found, needed) = (wire.read(id, OPERATING_MODE, 1)?[0], mode_of(servo.model));
        if found != needed {
            return Err(WireError::WrongMode { id, found, needed });
        }
        Ok(State::Holding(angle_rad(&wire.read(
            id,
            GOAL_POSITION,
            4,
        )?)))
    }

    fn configure(&self, wire: &mut Wire, servo: &Servo) -> Result<(), WireError> {
        // Both registers are in memory with limited write cycles, so they are written only on
        // change.
        for (register, value) in [(RETURN_DELAY, 0), (OPERATING_MODE, mode_of(servo.model))] {
            if wire.read(servo.id, register, 1)? != [value] {
                wire.write(servo.id, register, &[value])?;
            }
        }
        self.limit(wire, servo)
    }

    fn limit(&self, wire: &mut Wire, servo: &Servo) -> Result<(), WireError> {
        let (register, step) = match servo.model.current_step_a {
            Some(step_a) => (GOAL_CURRENT, step_a),
            None => (GOAL_PWM, PWM_STEP_PERCENT),
        };
        // Rounded down, so that the limit is never exceeded. A speed of 0 would mean "no limit".
        let limit = (servo.limit / step).floor() as i16;
        wire.write(servo.id, register, &limit.to_le_bytes())?;
        let speed = (servo.speed_max_rad_s / SPEED_STEP_RAD_S).floor().max(1.0) as u32;
        wire.write(servo.id, PROFILE_VELOCITY, &speed.to_le_bytes())
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
        let answers = wire.read_all(&ids, PRESENT_CURRENT, READ_BYTES)?;
        out.clear();
        out.extend(servos.iter().zip(answers).map(|(servo, (bytes, status))| {
            let step_a = servo.model.current_step_a.unwrap_or(0.0);
            Reading {
                current_a: f64::from(i16_of(&bytes[..2])) * step_a,
                velocity: f64::from(i32_of(&bytes[2..6])) * SPEED_STEP_RAD_S,
                position: angle_rad(&bytes[6..10]),
                alert: status & ALERT != 0,
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
        let state = wire.read(id, TORQUE_ENABLE, HARDWARE_ERROR - TORQUE_ENABLE + 1)?;
        let temperature = wire.read(id, PRESENT_TEMPERATURE, 1)?[0];
        let errors = state[usize::from(HARDWARE_ERROR - TORQUE_ENABLE)];
        let complaints = ERROR_TEXTS.iter().filter(|(bit, _)| errors >> bit & 1 == 1);
        Ok(Health {
            torque_on: state[0] != 0,
            temperature_c: f64::from(temperature),
            errors: complaints.map(|(_, words)| *words).collect(),
        })
    }
}
