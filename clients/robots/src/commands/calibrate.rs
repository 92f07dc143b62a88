//! `calibrate` and `relax`: the commands that switch torque off, at the user's request.
//!
//! The zero of a joint is its shaft angle while the user holds the joint at 0. Its direction is the
//! sign of the shaft rotation when the user moves the joint in its positive direction.

use std::io::{self, BufRead};
use std::path::Path;

use super::{print, print_message, write};
use crate::cli::Which;
use crate::drivers::wire::Wire;
use crate::failure::Failure;
use crate::map::file::MapFile;
use crate::map::{self, Check, MappedServo, PortMap};

/// Minimum shaft rotation that determines a direction, rad. Design choice: five degrees, more than
/// the backlash.
const TURN_MIN_RAD: f64 = 0.09;

/// Determines zeros and directions.
pub(super) fn run(which: &Which, out: Option<&Path>) -> Result<(), Failure> {
    let mut file = map::read(&which.map)?;
    for_each(which, |port, wire, mapped| {
        let (zero_rad, direction) = calibrate(port, wire, mapped)?;
        print_message(&format!(
            "{}: zero_rad {zero_rad:.4}, direction {direction}",
            mapped.name
        ));
        store_calibration(&mut file, mapped, zero_rad, direction);
        Ok(())
    })?;
    let text = toml::to_string(&file)
        .map_err(|error| Failure::Usage(format!("could not write the map: {error}")))?;
    match out {
        Some(path) => write(path, &text),
        None => print(text.trim_end()),
    }
}

/// Switches the torque of servos off.
pub(super) fn relax(which: &Which, yes: bool) -> Result<(), Failure> {
    if !yes {
        prompt(
            "The robot drops held objects and its arms fall. Support them, then press Enter (or \
             Ctrl-C to cancel)",
        )?;
    }
    for_each(which, |port, wire, mapped| {
        let off = port.driver.set_torque(wire, mapped.servo.id, false);
        off.map_err(|error| failed(port, mapped, &error.to_string()))?;
        print_message(&format!("{} has no torque", mapped.label()));
        Ok(())
    })
}

/// Calls `act` for each requested joint, or for all joints.
fn for_each(
    which: &Which,
    mut act: impl FnMut(&PortMap, &mut Wire, &MappedServo) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let map = map::load(&which.map, Check::Uncalibrated)?;
    let known = |name: &&String| map.joints.iter().any(|joint| joint.name == **name);
    if let Some(stranger) = which.joint.iter().find(|name| !known(name)) {
        return Err(Failure::Usage(format!(
            "the robot has no joint {stranger:?}"
        )));
    }
    let wanted =
        |mapped: &&MappedServo| which.joint.is_empty() || which.joint.contains(&mapped.name);
    for port in &map.ports {
        if !port.servos.iter().any(|mapped| wanted(&mapped)) {
            continue;
        }
        let protocol = port.driver.protocol();
        let mut wire = Wire::open(&port.device, port.baud, protocol, port.answer_within)
            .map_err(Failure::Servos)?;
        for mapped in port.servos.iter().filter(wanted) {
            act(port, &mut wire, mapped)?;
        }
    }
    Ok(())
}

fn calibrate(port: &PortMap, wire: &mut Wire, mapped: &MappedServo) -> Result<(f64, i8), Failure> {
    let name = &mapped.name;
    prompt(&format!(
        "{name}: support it, then press Enter to switch its torque off"
    ))?;
    let off = port.driver.set_torque(wire, mapped.servo.id, false);
    off.map_err(|error| failed(port, mapped, &error.to_string()))?;
    prompt(&format!("{name}: move it to 0, then press Enter"))?;
    let zero_rad = position(port, wire, mapped)?;
    loop {
        prompt(&format!(
            "{name}: move it slightly in its positive direction, then press Enter"
        ))?;
        let turn_rad = position(port, wire, mapped)? - zero_rad;
        if turn_rad.abs() >= TURN_MIN_RAD {
            return Ok((zero_rad, if turn_rad > 0.0 { 1 } else { -1 }));
        }
        print_message(&format!(
            "{name}: its shaft turned by {turn_rad:.3} rad only, needs {TURN_MIN_RAD}"
        ));
    }
}

fn position(port: &PortMap, wire: &mut Wire, mapped: &MappedServo) -> Result<f64, Failure> {
    let read = port.driver.position(wire, &mapped.servo);
    read.map_err(|error| failed(port, mapped, &error.to_string()))
}

fn store_calibration(file: &mut MapFile, mapped: &MappedServo, zero_rad: f64, direction: i8) {
    let servos = file.ports.iter_mut().flat_map(|port| &mut port.servos);
    for entry in servos.filter(|entry| entry.joint == mapped.name) {
        (entry.zero_rad, entry.direction) = (zero_rad, direction);
    }
}

fn failed(port: &PortMap, mapped: &MappedServo, why: &str) -> Failure {
    Failure::Servos(format!("{}, {}: {why}", port.device, mapped.label()))
}

/// Prints a prompt and waits for Enter.
fn prompt(what: &str) -> Result<(), Failure> {
    print_message(what);
    let read = io::stdin().lock().read_line(&mut String::new());
    match read {
        Ok(0) => Err(Failure::Usage(
            "standard input ended before the last step".to_owned(),
        )),
        Ok(_) => Ok(()),
        Err(error) => Err(Failure::Usage(format!(
            "could not read standard input: {error}"
        ))),
    }
}
