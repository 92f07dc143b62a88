//! Which servo moves which joint, and how: the servo map, checked.
//!
//! In: a TOML file ([`mod@file`]) and the robot's joints. Out: [`PortMap`]s whose servos each know their joint, or everything that is
//! wrong with the file at once. Invariants of a map: every joint has exactly one servo, ids are unique on their port, every number
//! is finite and within what the servo can do, and each servo's travel covers its joint's limits.

mod check;
pub mod file;

use std::path::Path;
use std::time::Duration;

use crate::drivers::{Driver, Reading, Servo};
use crate::failure::Failure;
use crate::joints::{self, Joint};
use file::MapFile;

/// How much of a map is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// Everything: the robot is to move.
    Whole,
    /// Everything but zeros and directions: they are to be found.
    Uncalibrated,
}

/// A robot of servos.
#[derive(Clone, Debug)]
pub struct Map {
    /// Its joints, in the order of the payloads.
    pub joints: Vec<Joint>,
    /// Its serial ports.
    pub ports: Vec<PortMap>,
}

/// One serial port.
#[derive(Clone)]
pub struct PortMap {
    /// Path of the terminal.
    pub device: String,
    /// The family of its servos.
    pub driver: &'static dyn Driver,
    /// Line speed, baud.
    pub baud: u32,
    /// Shortest time between two cycles.
    pub period: Duration,
    /// How long an answer may take.
    pub answer_within: Duration,
    /// Its servos.
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
    /// Its name.
    pub name: String,
    /// The servo.
    pub servo: Servo,
    /// Shaft angle per joint angle: gear with the sign of the direction.
    pub ratio: f64,
    /// Angle of the shaft where the joint is at 0, rad.
    pub zero_rad: f64,
    /// Torque of the shaft per current, N·m/A; zero if it is not known.
    pub torque_per_current_n_m_a: f64,
    /// Temperature from which the robot holds, °C.
    pub temperature_limit_c: f64,
    /// Limits of the joint, rad.
    pub limits_rad: (f64, f64),
}

/// What is known of one joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointReading {
    /// Position, rad.
    pub position_rad: f64,
    /// Velocity, rad/s.
    pub velocity_rad_s: f64,
    /// Effort, N·m.
    pub effort_n_m: f64,
}

impl MappedServo {
    /// The joint's angle at this angle of the shaft.
    #[must_use]
    pub fn joint_rad(&self, shaft_rad: f64) -> f64 {
        (shaft_rad - self.zero_rad) / self.ratio
    }

    /// The shaft's angle at this angle of the joint.
    #[must_use]
    pub fn shaft_rad(&self, joint_rad: f64) -> f64 {
        self.zero_rad + self.ratio * joint_rad
    }

    /// What a reading of the servo says of the joint.
    #[must_use]
    pub fn joint_reading(&self, reading: &Reading) -> JointReading {
        JointReading {
            position_rad: self.joint_rad(reading.position_rad),
            velocity_rad_s: reading.velocity_rad_s / self.ratio,
            effort_n_m: reading.current_a * self.torque_per_current_n_m_a * self.ratio,
        }
    }

    /// How people call it.
    #[must_use]
    pub fn called(&self) -> String {
        format!("servo {} ({})", self.servo.id, self.name)
    }
}

/// Reads a map's text, unchecked.
///
/// # Errors
/// [`Failure::Map`] if it is not there or is not such a file.
pub fn read(path: &Path) -> Result<MapFile, Failure> {
    let refused = |why: String| Failure::Map {
        file: path.display().to_string(),
        findings: vec![why],
    };
    let text = std::fs::read_to_string(path)
        .map_err(|error| refused(format!("could not read it: {error}")))?;
    toml::from_str(&text).map_err(|error| refused(error.to_string()))
}

/// Reads and checks a map.
///
/// # Errors
/// [`Failure::Map`] with everything that is wrong.
pub fn load(path: &Path, check: Check) -> Result<Map, Failure> {
    let file = read(path)?;
    checked(&file, check).map_err(|findings| Failure::Map {
        file: path.display().to_string(),
        findings,
    })
}

/// Checks a map.
///
/// # Errors
/// Everything that is wrong, each with its place.
pub fn checked(file: &MapFile, check: Check) -> Result<Map, Vec<String>> {
    let joints = joints::of(&file.robot).map_err(|why| vec![format!("robot: {why}")])?;
    check::ports(file, &joints, check).map(|ports| Map { joints, ports })
}
