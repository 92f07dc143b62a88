//! `emulate`: emulates the servos of a map behind pseudo-terminals.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

use serde_json::json;

use super::{print, stop_on_signal, write};
use crate::cli::Format;
use crate::emulator::{Chain, PlannedServo};
use crate::failure::Failure;
use crate::map::{self, Check, PortMap};

/// Interval between checks for a stop request.
const POLL: Duration = Duration::from_millis(50);

/// Runs the emulation until a stop request. With `rest`, the joints begin in the reference posture.
pub(super) fn run(map_path: &Path, out: &Path, rest: bool, format: Format) -> Result<(), Failure> {
    let mut file = map::read(map_path)?;
    let map = map::load(map_path, Check::Whole)?;
    let stop = stop_on_signal()?;
    let chains: Vec<Chain> = map
        .ports
        .iter()
        .map(|port| start_chain(port, rest))
        .collect::<Result<_, _>>()?;
    for (entry, chain) in file.ports.iter_mut().zip(&chains) {
        entry.device = chain.path().display().to_string();
    }
    let text = toml::to_string(&file)
        .map_err(|error| Failure::Usage(format!("could not write the map: {error}")))?;
    write(out, &text)?;
    let ports = file
        .ports
        .iter()
        .map(|port| (&port.device, port.servos.len()));
    if format == Format::Json {
        let ports = ports.map(|(device, servos)| json!({ "device": device, "servos": servos }));
        let ports: Vec<_> = ports.collect();
        print(&json!({ "map": out.display().to_string(), "ports": ports }).to_string())?;
    } else {
        for (device, servos) in ports {
            print(&format!("{device}: {servos} servos"))?;
        }
        print(&format!("atas-robot run {}", out.display()))?;
    }
    while !stop.load(Ordering::Relaxed) {
        std::thread::sleep(POLL);
    }
    Ok(())
}

fn start_chain(port: &PortMap, rest: bool) -> Result<Chain, Failure> {
    let planned = port.servos.iter().map(|mapped| {
        let (lower, upper) = mapped.limits_rad;
        let middle_rad = f64::midpoint(lower, upper);
        let joint_rad = if rest { mapped.rest_rad } else { middle_rad };
        PlannedServo {
            id: mapped.servo.id,
            model: mapped.servo.model.name.to_owned(),
            position: mapped.shaft_rad(joint_rad),
        }
    });
    let planned: Vec<PlannedServo> = planned.collect();
    Chain::start(port.driver.name(), &planned, Some(port.baud))
        .map_err(|error| Failure::Usage(format!("could not start the servo emulator: {error}")))
}
