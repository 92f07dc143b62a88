//! Interface of a servo family.

use super::protocol::Protocol;
use super::wire::{Wire, WireError};

/// Quantity that limits the force of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitKind {
    /// Current, A: the servo regulates its current.
    Current,
    /// Percent of the maximum: the servo limits its voltage or its torque.
    Torque,
}

/// One servo model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// Name in the servo map.
    pub name: &'static str,
    /// Value of the model register.
    pub number: u16,
    /// Unit of the current register, A; `None` without current measurement.
    pub current_step_a: Option<f64>,
    /// Quantity that limits the force.
    pub limit: LimitKind,
    /// Maximum of that limit, A or %.
    pub limit_max: f64,
    /// The goal may exceed one turn.
    pub multi_turn: bool,
    /// Default switch-off temperature, °C.
    pub temperature_max_c: f64,
}

/// Configuration of one servo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Servo {
    /// Id on the port.
    pub id: u8,
    /// Servo model.
    pub model: &'static Model,
    /// Force limit, A or %, see [`Model::limit`].
    pub limit: f64,
    /// Speed limit of the shaft, rad/s, enforced by the servo.
    pub speed_max_rad_s: f64,
}

/// Measurements of one servo.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Shaft angle, rad.
    pub position: f64,
    /// Shaft speed, rad/s.
    pub velocity: f64,
    /// Current, A, with the sign of the torque; 0 without measurement.
    pub current_a: f64,
    /// The servo reports an error; [`Driver::health`] returns it.
    pub alert: bool,
}

/// Health of one servo.
#[derive(Clone, Debug, PartialEq)]
pub struct Health {
    /// Torque is on.
    pub torque_on: bool,
    /// Temperature, °C.
    pub temperature_c: f64,
    /// Reported errors as text; empty if there are none.
    pub errors: Vec<&'static str>,
}

/// Torque state of a servo before the take-over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum State {
    /// Torque is on; holds this goal, rad.
    Holding(f64),
    /// Torque is off.
    TorqueOff,
}

/// One servo family. Stateless: the state of a port is in its [`Wire`].
///
/// Methods fail with a [`WireError`] that names the servo.
pub trait Driver: Sync {
    /// Returns the name in the servo map.
    fn name(&self) -> &'static str;

    /// Returns a description.
    fn about(&self) -> &'static str;

    /// Returns the protocol.
    fn protocol(&self) -> Protocol;

    /// Returns the supported line speeds, baud; the factory setting first.
    fn bauds(&self) -> &'static [u32];

    /// Returns the supported models.
    fn models(&self) -> &'static [Model];

    /// Returns the model with this name.
    fn model(&self, name: &str) -> Option<&'static Model> {
        self.models().iter().find(|model| model.name == name)
    }

    /// Reads the model register.
    fn model_number(&self, wire: &mut Wire, id: u8) -> Result<u16, WireError>;

    /// Selects the fastest read method that all servos support. By default, only one exists.
    fn choose_reading(&self, _wire: &mut Wire, _servos: &[Servo]) -> Result<(), WireError> {
        Ok(())
    }

    /// Returns the torque state. Rejects a servo with torque in another operating mode.
    fn state(&self, wire: &mut Wire, servo: &Servo) -> Result<State, WireError>;

    /// Writes mode and limits; torque must be off.
    fn configure(&self, wire: &mut Wire, servo: &Servo) -> Result<(), WireError>;

    /// Writes the limits that may change while the servo holds.
    fn limit(&self, wire: &mut Wire, servo: &Servo) -> Result<(), WireError>;

    /// Switches the torque. Before switching it on, write a goal.
    fn set_torque(&self, wire: &mut Wire, id: u8, on: bool) -> Result<(), WireError>;

    /// Reads all servos at once into `out`, in order.
    fn read(
        &self,
        wire: &mut Wire,
        servos: &[Servo],
        out: &mut Vec<Reading>,
    ) -> Result<(), WireError>;

    /// Reads the shaft angle of one servo, rad; repeats the request if the reply is missing or
    /// damaged.
    fn position(&self, wire: &mut Wire, servo: &Servo) -> Result<f64, WireError> {
        let mut reading = Vec::new();
        wire.repeat(|wire| self.read(wire, &[*servo], &mut reading))?;
        let first = reading.first().ok_or(WireError::NoReply(servo.id))?;
        Ok(first.position)
    }

    /// Writes all goals, rad, at once. Servos send no reply.
    fn write_goals(
        &self,
        wire: &mut Wire,
        servos: &[Servo],
        goals_rad: &[f64],
    ) -> Result<(), WireError>;

    /// Returns the goal, rad, rounded to the servo's resolution as in [`Driver::write_goals`].
    fn rounded(&self, goal_rad: f64) -> f64;

    /// Reads the health of one servo.
    fn health(&self, wire: &mut Wire, id: u8) -> Result<Health, WireError>;
}
