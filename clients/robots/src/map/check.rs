//! Validation of a servo map; reports all errors at once.

use core::f64::consts::TAU;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use super::file::{MapFile, PortEntry, ServoEntry};
use super::{Check, MappedServo, PortMap};
use crate::drivers::{self, Driver, LimitKind, Model, Servo};
use crate::joints::Joint;

/// Highest id: 253 to 255 are reserved (protocol 2.0).
const ID_MAX: u8 = 252;
/// Highest gear. Design choice.
const GEAR_MAX: f64 = 1000.0;
/// Servo speed limit per joint speed limit. Design choice: 10 % above the daemon's commands, so
/// that the servo can catch up.
const SPEED_SHARE: f64 = 1.1;
/// Default margin below the servo's switch-off temperature, K. Design choice.
const TEMPERATURE_MARGIN_K: f64 = 10.0;

struct Checker<'a> {
    joints: &'a [Joint],
    check: Check,
    findings: Vec<String>,
    /// Location of the servo by joint index.
    assigned: BTreeMap<usize, String>,
}

/// Returns the ports of a map, or all errors.
pub(super) fn ports(
    file: &MapFile,
    joints: &[Joint],
    check: Check,
) -> Result<Vec<PortMap>, Vec<String>> {
    let mut checker = Checker {
        joints,
        check,
        findings: Vec::new(),
        assigned: BTreeMap::new(),
    };
    let ports: Vec<_> = file
        .ports
        .iter()
        .filter_map(|entry| checker.port(entry))
        .collect();
    checker.devices(&file.ports);
    checker.missing_joints();
    if checker.findings.is_empty() {
        Ok(ports)
    } else {
        Err(checker.findings)
    }
}

impl Checker<'_> {
    fn report(&mut self, place: &str, what: impl AsRef<str>) {
        self.findings.push(format!("{place}: {}", what.as_ref()));
    }

    /// Reports a value outside its range.
    fn within(&mut self, place: &str, key: &str, value: f64, (low, high): (f64, f64)) {
        // False for NaN.
        if !(value >= low && value <= high) {
            self.report(place, format!("{key} is {value}, needs {low} to {high}"));
        }
    }

    fn devices(&mut self, ports: &[PortEntry]) {
        if ports.is_empty() {
            self.report("port", "no port defined; a map needs at least one [[port]]");
        }
        let mut seen = BTreeSet::new();
        for port in ports.iter().filter(|port| !seen.insert(&port.device)) {
            self.report(
                &port.device,
                "device is listed twice; list all its servos under one [[port]]",
            );
        }
    }

    fn missing_joints(&mut self) {
        let missing: Vec<&str> = (0..self.joints.len())
            .filter(|joint| !self.assigned.contains_key(joint))
            .map(|joint| self.joints[joint].name.as_str())
            .collect();
        if !missing.is_empty() {
            let names = missing.join(", ");
            self.report(
                "servo",
                format!("no servo for {names}; the daemon requires all joints of the robot"),
            );
        }
    }

    fn port(&mut self, entry: &PortEntry) -> Option<PortMap> {
        let place = entry.device.as_str();
        self.within(place, "rate_hz", entry.rate_hz, (1.0, 10_000.0));
        self.within(
            place,
            "answer_within_ms",
            entry.answer_within_ms,
            (1.0, 1000.0),
        );
        let Some(driver) = drivers::find(&entry.driver) else {
            let known: Vec<_> = drivers::DRIVERS
                .iter()
                .map(|driver| driver.name())
                .collect();
            let known = known.join(" or ");
            self.report(
                place,
                format!("driver is {:?}, needs {known}", entry.driver),
            );
            return None;
        };
        if !driver.bauds().contains(&entry.baud) {
            let known = driver.bauds();
            self.report(
                place,
                format!("baud is {}, needs one of {known:?}", entry.baud),
            );
        }
        let mut ids = BTreeSet::new();
        for twice in entry.servos.iter().filter(|servo| !ids.insert(servo.id)) {
            self.report(place, format!("id {} is used twice", twice.id));
        }
        if entry.servos.is_empty() {
            self.report(place, "no [[port.servo]] defined");
        }
        let servos = entry
            .servos
            .iter()
            .filter_map(|servo| self.servo(place, driver, servo))
            .collect();
        Some(PortMap {
            device: entry.device.clone(),
            driver,
            baud: entry.baud,
            period: seconds(1.0 / entry.rate_hz),
            answer_within: seconds(entry.answer_within_ms / 1000.0),
            servos,
        })
    }

    fn servo(
        &mut self,
        device: &str,
        driver: &'static dyn Driver,
        entry: &ServoEntry,
    ) -> Option<MappedServo> {
        let place = format!("{device}, servo {}", entry.id);
        if entry.id > ID_MAX {
            self.report(&place, format!("id out of range, needs 0 to {ID_MAX}"));
        }
        if !matches!(entry.direction, 1 | -1) {
            self.report(
                &place,
                format!("direction is {}, needs 1 or -1", entry.direction),
            );
        }
        self.within(&place, "gear", entry.gear, (1.0 / GEAR_MAX, GEAR_MAX));
        self.within(&place, "zero_rad", entry.zero_rad, (-GEAR_MAX, GEAR_MAX));
        let torque_per_current = entry.torque_per_current_n_m_a.unwrap_or(0.0);
        self.within(
            &place,
            "torque_per_current_n_m_a",
            torque_per_current,
            (0.0, 1000.0),
        );
        let joint = self.joint(&place, &entry.joint);
        let model = driver.model(&entry.model);
        if model.is_none() {
            let known: Vec<_> = driver.models().iter().map(|model| model.name).collect();
            let known = known.join(", ");
            self.report(
                &place,
                format!("model is {:?}, needs one of {known}", entry.model),
            );
        }
        let (joint, model) = (joint?, model?);
        let limit = self.limit(&place, model, entry)?;
        let hot_c = entry
            .temperature_limit_c
            .unwrap_or(model.temperature_max_c - TEMPERATURE_MARGIN_K);
        self.within(
            &place,
            "temperature_limit_c",
            hot_c,
            (20.0, model.temperature_max_c),
        );
        let known = &self.joints[joint];
        let mapped = MappedServo {
            joint,
            name: known.name.clone(),
            servo: Servo {
                id: entry.id,
                model,
                limit,
                speed_max_rad_s: SPEED_SHARE * known.speed_max_rad_s * entry.gear,
            },
            ratio: entry.gear * f64::from(entry.direction),
            zero_rad: entry.zero_rad,
            torque_per_current_n_m_a: torque_per_current,
            temperature_limit_c: hot_c,
            rest_rad: known.rest_rad,
            limits_rad: (known.lower, known.upper),
        };
        self.travel(&place, &mapped);
        Some(mapped)
    }

    fn joint(&mut self, place: &str, name: &str) -> Option<usize> {
        let Some(joint) = self.joints.iter().position(|joint| joint.name == name) else {
            self.report(place, format!("the robot has no joint {name:?}"));
            return None;
        };
        if let Some(other) = self.assigned.insert(joint, place.to_owned()) {
            self.report(place, format!("{name} is already assigned to {other}"));
        }
        Some(joint)
    }

    /// Returns the force limit in the unit of the model.
    fn limit(&mut self, place: &str, model: &Model, entry: &ServoEntry) -> Option<f64> {
        let current = ("current_limit_a", entry.current_limit_a);
        let torque = ("torque_limit_percent", entry.torque_limit_percent);
        let ((key, value), (other, unusable)) = match model.limit {
            LimitKind::Current => (current, torque),
            LimitKind::Torque => (torque, current),
        };
        if unusable.is_some() {
            self.report(
                place,
                format!("{} is not limited by {other}; give {key}", model.name),
            );
        }
        let Some(value) = value else {
            let most = model.limit_max;
            self.report(place, format!("{key} is missing, needs at most {most}"));
            return None;
        };
        self.within(place, key, value, (0.01, model.limit_max));
        Some(value)
    }

    /// Rejects a single-turn servo that cannot reach both joint limits within its turn.
    fn travel(&mut self, place: &str, servo: &MappedServo) {
        if self.check == Check::Uncalibrated || servo.servo.model.multi_turn {
            return;
        }
        let (lower, upper) = servo.limits_rad;
        let ends = [servo.shaft_rad(lower), servo.shaft_rad(upper)];
        // False for NaN, which is reported separately.
        if ends.iter().any(|end| *end < 0.0 || *end >= TAU) {
            let [from, to] = ends;
            self.report(
                place,
                format!(
                    "the limits of {} are at {from:.3} and {to:.3} rad of its shaft, which turns from 0 to {TAU:.3}; choose \
                     another zero_rad or gear",
                    servo.name
                ),
            );
        }
    }
}

/// Returns a duration; out-of-range values are already reported.
fn seconds(value: f64) -> Duration {
    Duration::try_from_secs_f64(value).unwrap_or_default()
}
