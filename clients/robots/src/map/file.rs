//! TOML format of the servo map.

use robot_model::TWO_HAND_ARM;
use serde::{Deserialize, Serialize};

/// The whole file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapFile {
    /// Built-in robot or robot file, as configured in the daemon.
    #[serde(default = "two_hand_arm")]
    pub robot: String,
    /// Serial ports.
    #[serde(default, rename = "port")]
    pub ports: Vec<PortEntry>,
}

/// One serial port with its servos.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PortEntry {
    /// Path of the serial port.
    pub device: String,
    /// Servo family.
    pub driver: String,
    /// Line speed, baud.
    pub baud: u32,
    /// Maximum cycles per second.
    #[serde(default = "default_rate_hz")]
    pub rate_hz: f64,
    /// Timeout of a reply, ms.
    #[serde(default = "default_answer_ms")]
    pub answer_within_ms: f64,
    /// Servos on the port.
    #[serde(default, rename = "servo")]
    pub servos: Vec<ServoEntry>,
}

/// One servo.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ServoEntry {
    /// Name of the joint.
    pub joint: String,
    /// Servo id.
    pub id: u8,
    /// Servo model.
    pub model: String,
    /// 1 if shaft and joint turn in the same direction, otherwise -1.
    #[serde(default = "forward")]
    pub direction: i8,
    /// Shaft angle at joint position 0, rad.
    pub zero_rad: f64,
    /// Shaft turns per joint turn.
    #[serde(default = "direct")]
    pub gear: f64,
    /// Current limit, A, for models with current regulation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub current_limit_a: Option<f64>,
    /// Torque limit, %, for other models.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_limit_percent: Option<f64>,
    /// Shaft torque per current, N·m/A, from the datasheet; without it, efforts are reported as
    /// zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_per_current_n_m_a: Option<f64>,
    /// Temperature above which the robot holds, °C; default 10 below the servo's switch-off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature_limit_c: Option<f64>,
}

fn two_hand_arm() -> String {
    TWO_HAND_ARM.name.to_string()
}

/// Default rate. Design choice: reached by a port at 1 MBd with a few servos; a slower port runs at
/// its maximum.
fn default_rate_hz() -> f64 {
    500.0
}

/// Default timeout. Design choice: half of the default latency timer of an FTDI adapter (16 ms),
/// which must be set to 1 ms.
fn default_answer_ms() -> f64 {
    8.0
}

fn forward() -> i8 {
    1
}

fn direct() -> f64 {
    1.0
}
