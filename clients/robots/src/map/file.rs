//! The servo map as it stands in its TOML file.

use robot_model::TWO_HAND_ARM;
use serde::{Deserialize, Serialize};

/// The whole file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapFile {
    /// The robot whose joints these are: one that ships, or a robot file, as the daemon is told.
    #[serde(default = "two_hand_arm")]
    pub robot: String,
    /// The serial ports.
    #[serde(default, rename = "port")]
    pub ports: Vec<PortEntry>,
}

/// One serial port with its servos.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PortEntry {
    /// Path of the terminal.
    pub device: String,
    /// Family of its servos.
    pub driver: String,
    /// Line speed, baud.
    pub baud: u32,
    /// Most cycles per second.
    #[serde(default = "usual_rate_hz")]
    pub rate_hz: f64,
    /// How long an answer may take, ms.
    #[serde(default = "usual_answer_ms")]
    pub answer_within_ms: f64,
    /// The servos on it.
    #[serde(default, rename = "servo")]
    pub servos: Vec<ServoEntry>,
}

/// One servo.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ServoEntry {
    /// The joint that it moves.
    pub joint: String,
    /// Its id.
    pub id: u8,
    /// Its model.
    pub model: String,
    /// 1 if the shaft turns as the joint does, -1 if it turns the other way.
    #[serde(default = "forward")]
    pub direction: i8,
    /// Angle of the shaft where the joint is at 0, rad.
    pub zero_rad: f64,
    /// Turns of the shaft per turn of the joint.
    #[serde(default = "direct")]
    pub gear: f64,
    /// Most current that it may take, A, for a model that regulates its current.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub current_limit_a: Option<f64>,
    /// Most torque that it may give, %, for a model that does not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_limit_percent: Option<f64>,
    /// Torque of the shaft per current, N·m/A, of the model's sheet; without it efforts are told as zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_per_current_n_m_a: Option<f64>,
    /// Temperature from which the robot holds, °C; by default 10 below where the servo switches itself off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature_limit_c: Option<f64>,
}

fn two_hand_arm() -> String {
    TWO_HAND_ARM.name.to_string()
}

/// Ours: what a port at 1 MBd with a few servos reaches; a slower one goes as fast as it can.
fn usual_rate_hz() -> f64 {
    500.0
}

/// Ours: half of what the latency timer of an FTDI bridge takes as it is delivered (16 ms); set that to 1 ms.
fn usual_answer_ms() -> f64 {
    8.0
}

fn forward() -> i8 {
    1
}

fn direct() -> f64 {
    1.0
}
