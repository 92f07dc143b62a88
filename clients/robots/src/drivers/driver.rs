//! What a servo family is to the rest of this process.

use super::wire::{Protocol, Wire, WireError};

/// By what a model's force is limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitKind {
    /// Amperes: the servo regulates its current.
    Current,
    /// Percent of what it can: the servo limits its voltage or its torque as a whole.
    Torque,
}

/// One model of servo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// Its name in the servo map.
    pub name: &'static str,
    /// What its model register says.
    pub number: u16,
    /// Amperes per unit of its current register; `None` if it does not measure current.
    pub current_step_a: Option<f64>,
    /// By what its force is limited.
    pub limit: LimitKind,
    /// Highest value that limit takes, A or %.
    pub limit_max: f64,
    /// Whether its goal may lie outside one turn.
    pub multi_turn: bool,
    /// Temperature at which it switches itself off as it is delivered, °C.
    pub temperature_max_c: f64,
}

/// One servo as it shall be driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Servo {
    /// Its id on the port.
    pub id: u8,
    /// Its model.
    pub model: &'static Model,
    /// Most that it may press with, A or %, as its model limits it.
    pub limit: f64,
    /// Fastest that its shaft may turn, rad/s: enforced by the servo itself.
    pub speed_max_rad_s: f64,
}

/// What one servo measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Angle of the shaft, rad.
    pub position_rad: f64,
    /// Its speed, rad/s.
    pub velocity_rad_s: f64,
    /// Current, A, with the sign of the torque; zero where it is not measured.
    pub current_a: f64,
    /// Whether the servo says that something is wrong: [`Driver::health`] tells what.
    pub alert: bool,
}

/// How a servo is.
#[derive(Clone, Debug, PartialEq)]
pub struct Health {
    /// Whether its torque is on.
    pub torque_on: bool,
    /// Its temperature, °C.
    pub temperature_c: f64,
    /// What it reports of itself, in words; empty when all is well.
    pub complaints: Vec<&'static str>,
}

/// Whether a servo that is taken over holds already.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum State {
    /// Torque is on: it holds this goal, rad.
    Holding(f64),
    /// Torque is off.
    Loose,
}

/// One servo family. Without state: what is known of a port lies in its [`Wire`].
///
/// Every method fails with a [`WireError`] that names the servo.
pub trait Driver: Sync {
    /// Name in the servo map.
    fn name(&self) -> &'static str;

    /// What it is, for people.
    fn about(&self) -> &'static str;

    /// What its ports speak.
    fn protocol(&self) -> Protocol;

    /// Line speeds that its servos can be set to, baud, the one that they are delivered with first.
    fn bauds(&self) -> &'static [u32];

    /// Its models.
    fn models(&self) -> &'static [Model];

    /// The model with this name.
    fn model(&self, name: &str) -> Option<&'static Model> {
        self.models().iter().find(|model| model.name == name)
    }

    /// What the model register of a servo says.
    fn model_number(&self, wire: &mut Wire, id: u8) -> Result<u16, WireError>;

    /// Finds the fastest way of reading that all of these servos know.
    fn choose_reading(&self, wire: &mut Wire, servos: &[Servo]) -> Result<(), WireError>;

    /// Whether a servo holds, and what. A servo that holds in a mode that is not ours is refused.
    fn state(&self, wire: &mut Wire, servo: &Servo) -> Result<State, WireError>;

    /// Writes mode and limits of a servo whose torque is off.
    fn configure(&self, wire: &mut Wire, servo: &Servo) -> Result<(), WireError>;

    /// Writes those limits that may change while it holds.
    fn limit(&self, wire: &mut Wire, servo: &Servo) -> Result<(), WireError>;

    /// Switches torque. Whoever switches it on has written a goal first.
    fn set_torque(&self, wire: &mut Wire, id: u8, on: bool) -> Result<(), WireError>;

    /// Reads all servos at once into `out`, in their order.
    fn read(
        &self,
        wire: &mut Wire,
        servos: &[Servo],
        out: &mut Vec<Reading>,
    ) -> Result<(), WireError>;

    /// Writes all goals, rad, at once. Nobody answers.
    fn write_goals(
        &self,
        wire: &mut Wire,
        servos: &[Servo],
        goals_rad: &[f64],
    ) -> Result<(), WireError>;

    /// The goal of this angle as the servo takes it, rad: what [`Driver::write_goals`] makes of it.
    fn rounded(&self, goal_rad: f64) -> f64;

    /// How one servo is.
    fn health(&self, wire: &mut Wire, id: u8) -> Result<Health, WireError>;
}
