//! Servo map: assignment of servos to joints, validated.
//!
//! Inputs: a TOML file ([`mod@file`]) and the robot's joints. Output: [`PortMap`]s, or all errors
//! of the file. Invariants: every joint has exactly one servo, ids are unique per port, all numbers
//! are finite and within the servo's range, and each servo's travel covers its joint's limits.

mod check;
pub mod file;

use std::path::Path;
use std::time::Duration;

use crate::drivers::{Driver, Reading, Servo};
use crate::failure::Failure;
use crate::joints::{self, Joint};
use file::MapFile;

/// Scope of the validation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// Everything, for motion.
    Whole,
    /// Everything except zeros and directions, for calibration.
    Uncalibrated,
}

/// A validated servo map.
#[derive(Clone, Debug)]
pub struct Map {
    /// Joints in payload order.
    pub joints: Vec<Joint>,
    /// Serial ports.
    pub ports: Vec<PortMap>,
}

/// One serial port.
#[derive(Clone)]
pub struct PortMap {
    /// Path of the serial port.
    pub device: String,
    /// Servo family.
    pub driver: &'static dyn Driver,
    /// Line speed, baud.
    pub baud: u32,
    /// Minimum time between cycles.
    pub period: Duration,
    /// Timeout of a reply.
    pub answer_within: Duration,
    /// Servos on the port.
    pub servos: Vec<MappedServo>,
}

impl std::fmt::Debug for PortMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "PortMap({}, {})", self.device, self.driver.name())
    }
}

/// One servo and its joint.
#[derive(Clone, Debug, PartialEq)]
pub struct MappedServo {
    /// Index of the joint in the payloads.
    pub joint: usize,
    /// Name of the joint.
    pub name: String,
    /// Configuration of the servo.
    pub servo: Servo,
    /// Shaft angle per joint angle: gear with the sign of the direction.
    pub ratio: f64,
    /// Shaft angle at joint position 0, rad.
    pub zero_rad: f64,
    /// Shaft torque per current, N·m/A; 0 if unknown.
    pub torque_per_current_n_m_a: f64,
    /// Temperature above which the robot holds, °C.
    pub temperature_limit_c: f64,
    /// Position of the joint in the reference posture of the robot file, rad or m.
    pub rest_rad: f64,
    /// Limits of the joint, rad.
    pub limits_rad: (f64, f64),
}

/// Measurements of one joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointReading {
    /// Position, rad or m.
    pub position: f64,
    /// Velocity, rad/s or m/s.
    pub velocity: f64,
    /// Effort, N·m.
    pub effort: f64,
}

impl MappedServo {
    /// Returns the joint angle for a shaft angle.
    #[must_use]
    pub fn joint_rad(&self, shaft_rad: f64) -> f64 {
        (shaft_rad - self.zero_rad) / self.ratio
    }

    /// Returns the shaft angle for a joint angle.
    #[must_use]
    pub fn shaft_rad(&self, joint_rad: f64) -> f64 {
        self.zero_rad + self.ratio * joint_rad
    }

    /// Converts a servo reading to the joint.
    #[must_use]
    pub fn joint_reading(&self, reading: &Reading) -> JointReading {
        JointReading {
            position: self.joint_rad(reading.position),
            velocity: reading.velocity / self.ratio,
            effort: reading.current_a * self.torque_per_current_n_m_a * self.ratio,
        }
    }

    /// Returns the name for messages: servo id and joint.
    #[must_use]
    pub fn label(&self) -> String {
        format!("servo {} ({})", self.servo.id, self.name)
    }
}

/// Reads a map without validation.
///
/// # Errors
/// [`Failure::Map`] if the file is missing or not valid TOML of a map.
pub fn read(path: &Path) -> Result<MapFile, Failure> {
    let refused = |why: String| Failure::Map {
        file: path.display().to_string(),
        findings: vec![why],
    };
    let text = atas_text_file::read(path)
        .map_err(|error| refused(format!("could not read it: {error}")))?;
    toml::from_str(&text).map_err(|error| refused(error.to_string()))
}

/// Reads and validates a map.
///
/// # Errors
/// [`Failure::Map`] with all errors.
pub fn load(path: &Path, check: Check) -> Result<Map, Failure> {
    let file = read(path)?;
    validate(&file, check).map_err(|findings| Failure::Map {
        file: path.display().to_string(),
        findings,
    })
}

/// Validates a map.
///
/// # Errors
/// All errors, each with its location.
pub fn validate(file: &MapFile, check: Check) -> Result<Map, Vec<String>> {
    let joints = joints::load(&file.robot).map_err(|why| vec![format!("robot: {why}")])?;
    check::ports(file, &joints, check).map(|ports| Map { joints, ports })
}
