//! `probe`: identifies the sensor on a port.
//!
//! Tries every sensor with a fitting transport, at its speed and with default options: first
//! listens, then starts and polls. Never zeroes the device.

use std::time::Duration;

use serde_json::json;
use shm_bus::now_ns;

use super::print;
use crate::cli::{self, Format};
use crate::failure::Failure;
use crate::transport::{self, Input, READ_BYTES, Transport};
use crate::wire::{Driver, Event, Interface, Request, SENSORS, SensorType};

/// Listening time. Design choice: three frames of the slowest sensor.
const LISTEN_TIME: Duration = Duration::from_millis(300);
/// Frames that identify a sensor. Design choice: one may be a coincidence.
const FRAMES_TO_IDENTIFY: u64 = 2;

/// Result of one driver on the port.
struct Finding {
    sensor: &'static SensorType,
    frames: u64,
    junk_bytes: u64,
    rate_hz: f64,
    /// Type of frames of another kind.
    foreign: Option<&'static str>,
}

pub(super) fn run(device: &str, format: Format) -> Result<(), Failure> {
    let outcome = probe(device);
    if let (Format::Json, Err(failure)) = (format, &outcome) {
        print(&json!({ "device": device, "error": failure.to_string() }).to_string())?;
    }
    let found = outcome?;
    if format == Format::Json {
        let found: Vec<_> = found
            .iter()
            .map(|finding| {
                json!({
                    "name": finding.sensor.name,
                    "frames": finding.frames,
                    "junk_bytes": finding.junk_bytes,
                    "rate_hz": finding.rate_hz.round(),
                    "needs": finding.foreign,
                })
            })
            .collect();
        return print(&json!({ "device": device, "found": found }).to_string());
    }
    if found.is_empty() {
        return print(&format!(
            "{device}: no known sensor recognised; check cable and power"
        ));
    }
    for finding in &found {
        let Finding {
            sensor, rate_hz, ..
        } = finding;
        let needs = finding.foreign.map(|kind| format!(", {kind}"));
        print(&format!(
            "{device}: {} ({}), {rate_hz:.0} Hz{}",
            sensor.name,
            sensor.about,
            needs.unwrap_or_default()
        ))?;
    }
    Ok(())
}

fn fits(way: Interface, device: &str) -> bool {
    let is_path = device.starts_with('/') || device.starts_with('.');
    match way {
        Interface::Serial { .. } => is_path,
        Interface::WebSocket { .. } => device.starts_with("ws://"),
        Interface::Udp { .. } => !is_path && !device.starts_with("ws://"),
    }
}

fn probe(device: &str) -> Result<Vec<Finding>, Failure> {
    let mut found = Vec::new();
    for sensor in SENSORS
        .iter()
        .filter(|sensor| fits(sensor.interface, device))
    {
        let mut transport =
            transport::open(sensor.interface, device).map_err(|reason| Failure::Open {
                device: device.to_owned(),
                reason,
            })?;
        let finding = identify(sensor, transport.as_mut())?;
        if finding.frames >= FRAMES_TO_IDENTIFY {
            found.push(finding);
        }
    }
    found.sort_by_key(|finding| finding.junk_bytes);
    Ok(found)
}

/// Creates the sensor's driver with default options.
fn default_driver(sensor: &SensorType) -> Result<Box<dyn Driver>, Failure> {
    let usage = |reason: String| Failure::Usage(reason);
    let line = ["atas-sensor", sensor.name, "--device", "-", "--dry-run"];
    let matches = cli::command()
        .try_get_matches_from(line)
        .map_err(|error| usage(error.to_string()))?;
    let (_, matches) = matches
        .subcommand()
        .ok_or_else(|| usage("needs a sensor".to_owned()))?;
    let request = Request {
        rate_hz: sensor.rate_hz.parse().unwrap_or(100),
        zero: false,
    };
    (sensor.driver)(matches, &request).map_err(usage)
}

fn identify(
    sensor: &'static SensorType,
    transport: &mut dyn Transport,
) -> Result<Finding, Failure> {
    let mut driver = default_driver(sensor)?;
    let dialogue = driver.messages();
    let mut finding = Finding {
        sensor,
        frames: 0,
        junk_bytes: 0,
        rate_hz: 0.0,
        foreign: None,
    };
    let mut buffer = vec![0; READ_BYTES];
    // First listen only, then start and poll.
    for started in [false, true] {
        if started && transport.accepts_messages() && finding.frames == 0 {
            // Another device may not accept the command.
            let _ = transport.write(&dialogue.start);
        }
        let (begun_ns, before) = (now_ns(), finding.frames);
        let listen_ns = LISTEN_TIME.as_nanos() as u64;
        let mut polled_ns = 0;
        while now_ns() - begun_ns < listen_ns {
            if started && !dialogue.poll.is_empty() && now_ns() - polled_ns > 20_000_000 {
                let _ = transport.write(&dialogue.poll);
                polled_ns = now_ns();
            }
            if let Input::Bytes(length) = transport.read(&mut buffer, Duration::from_millis(10)) {
                driver.receive(&buffer[..length], &mut |event| match event {
                    Event::Frame(_) => finding.frames += 1,
                    Event::OtherKind(kind) => {
                        finding.frames += 1;
                        finding.foreign = Some(kind);
                    }
                    Event::Acknowledged(_) => {}
                });
                polled_ns = 0;
            }
        }
        let seconds = (now_ns() - begun_ns) as f64 / 1e9;
        finding.rate_hz = finding
            .rate_hz
            .max((finding.frames - before) as f64 / seconds);
        if finding.frames >= FRAMES_TO_IDENTIFY {
            break;
        }
    }
    if !dialogue.stop.is_empty() {
        let _ = transport.write(&dialogue.stop);
    }
    finding.junk_bytes = driver.counts().junk;
    Ok(finding)
}
