//! Plan from a command line or hand file: ports, settings and destination.

use std::path::Path;

use clap::{ArgMatches, FromArgMatches};
use shm_schemas::Layout;
use shm_schemas::capacity::ELEMENTS;
use shm_schemas::layout::NamedLayout;
use toml::Value;

use crate::calibration::Calibration;
use crate::cli::{self, PortArgs};
use crate::failure::Failure;
use crate::hand::{self, Destination, DeviceSlot};
use crate::mapping::Mapping;
use crate::newtons::Newtons;
use crate::port::Settings;
use crate::reading::Shape;
use crate::wire::{Driver, Request, SensorType, Zero, named};

/// Device to read.
pub struct Port {
    /// Sensor type.
    pub sensor: &'static SensorType,
    /// Port settings.
    pub settings: Settings,
    /// Driver.
    pub driver: Box<dyn Driver>,
    /// Conversion to newtons, if known.
    pub newtons: Option<Newtons>,
    /// Index of its first fingertip.
    pub finger: usize,
}

/// Devices and destination.
pub struct Plan {
    /// Devices.
    pub ports: Vec<Port>,
    /// Bus, hand and layout; `None` in a dry run.
    pub destination: Option<Destination>,
}

impl Port {
    /// Returns the frame content.
    #[must_use]
    pub fn shape(&self) -> Shape {
        self.driver.shape()
    }
}

impl Plan {
    /// Creates a plan from a sensor's subcommand.
    ///
    /// # Errors
    /// [`Failure::Usage`] with the cause.
    pub fn from_sensor(sensor: &'static SensorType, matches: &ArgMatches) -> Result<Self, Failure> {
        let args = PortArgs::from_arg_matches(matches)
            .map_err(|error| Failure::Usage(error.to_string()))?;
        let mut finger = args.finger as usize;
        let mut ports = Vec::new();
        let mut calibrations = calibrations(&args)?;
        for device in &args.device {
            let port = make_port(sensor, matches, &args, device, finger, &mut calibrations)?;
            finger += port.shape().fingers;
            ports.push(port);
        }
        if !calibrations.is_empty() {
            return Err(Failure::Usage(format!(
                "could not use all calibrations: {} are left over; give --calibration once per fingertip",
                calibrations.len()
            )));
        }
        if args.dry_run && ports.len() > 1 {
            return Err(Failure::Usage(
                "could not print several devices as one table; give --dry-run one --device"
                    .to_owned(),
            ));
        }
        reject_conflicts(&ports)?;
        let place = match (args.dry_run, args.hand) {
            (false, Some(hand)) => Some(Destination {
                bus: args.bus,
                hand,
                layout: layout(args.layout.as_deref(), max_elements(&ports))?,
            }),
            _ => None,
        };
        Ok(Self {
            ports,
            destination: place,
        })
    }

    /// Reads a plan from a hand file.
    ///
    /// # Errors
    /// [`Failure::Usage`] with file and cause.
    pub fn from_file(path: &Path) -> Result<Self, Failure> {
        let refuse =
            |reason: String| Failure::Usage(format!("could not read {}: {reason}", path.display()));
        let text = atas_text_file::read(path).map_err(|error| refuse(error.to_string()))?;
        Self::from_toml(&text).map_err(|reason| refuse(reason.to_string()))
    }

    /// Parses the text of a hand file.
    ///
    /// # Errors
    /// [`Failure::Usage`] with the cause.
    pub fn from_toml(text: &str) -> Result<Self, Failure> {
        let mut table: toml::Table = text
            .parse()
            .map_err(|error: toml::de::Error| Failure::Usage(error.to_string()))?;
        let ports = table.remove("port");
        let Some(Value::Array(ports)) =
            ports.filter(|ports| !matches!(ports, Value::Array(a) if a.is_empty()))
        else {
            return Err(Failure::Usage(
                "it names no [[port]]; add one or more".to_owned(),
            ));
        };
        if let Some(key) = table
            .keys()
            .find(|key| !["hand", "bus", "layout"].contains(&key.as_str()))
        {
            return Err(Failure::Usage(format!(
                "it has the key {key:?}, which is unknown; use hand, bus, layout and [[port]]"
            )));
        }
        let mut plan = Self {
            ports: Vec::new(),
            destination: None,
        };
        for (n, port) in ports.iter().enumerate() {
            let one = parse_port(port, &table)
                .map_err(|reason| Failure::Usage(format!("[[port]] {}: {reason}", n + 1)))?;
            plan.ports.extend(one.ports);
            plan.destination = plan.destination.or(one.destination);
        }
        reject_conflicts(&plan.ports)?;
        if let Some(place) = &mut plan.destination {
            let wanted = table.get("layout").and_then(Value::as_str);
            place.layout = layout(wanted, max_elements(&plan.ports))?;
        }
        Ok(plan)
    }

    /// Returns the slots of the ports with a known conversion to newtons; in a dry run some may
    /// lack it.
    #[must_use]
    pub fn slots(&self) -> Vec<DeviceSlot> {
        let seat = |port: &Port| {
            Some(DeviceSlot {
                driver: port.sensor.name,
                device: port.settings.device.clone(),
                finger: port.finger,
                shape: port.shape(),
                newtons: port.newtons.clone()?,
                period_ns: port.settings.period_ns,
            })
        };
        self.ports.iter().filter_map(seat).collect()
    }
}

fn make_port(
    sensor: &'static SensorType,
    matches: &ArgMatches,
    args: &PortArgs,
    device: &str,
    finger: usize,
    calibrations: &mut Vec<Calibration>,
) -> Result<Port, Failure> {
    let request = Request {
        rate_hz: args.rate_hz,
        zero: args.zero && sensor.zero == Zero::Device,
    };
    let driver = (sensor.driver)(matches, &request).map_err(Failure::Usage)?;
    let settings = Settings {
        device: device.to_owned(),
        way: sensor.interface,
        period_ns: 1_000_000_000 / u64::from(args.rate_hz.max(1)),
        configure: !args.no_configure,
        tare: args.zero && sensor.zero == Zero::Host,
        recording_allowed: args.dry_run,
        reconnect: args.reconnect,
    };
    let scaled = || {
        let of = |scale| Mapping {
            scale,
            axes: args.axes,
        };
        args.newtons_per_count.map(of).map(Newtons::Scaled)
    };
    let newtons = if args.calibration.is_empty() {
        scaled()
    } else {
        Some(take_calibrations(
            driver.shape(),
            device,
            calibrations,
            args.zero,
        )?)
    };
    Ok(Port {
        sensor,
        settings,
        driver,
        newtons,
        finger,
    })
}

/// Reads the calibrations of the command line.
fn calibrations(args: &PortArgs) -> Result<Vec<Calibration>, Failure> {
    args.calibration
        .iter()
        .map(|path| Calibration::open(path).map_err(|error| Failure::Usage(error.to_string())))
        .collect()
}

/// Removes the next device's calibrations from the list; clears their zero if the device is zeroed
/// at the start.
fn take_calibrations(
    shape: Shape,
    device: &str,
    calibrations: &mut Vec<Calibration>,
    is_zeroed: bool,
) -> Result<Newtons, Failure> {
    if calibrations.len() < shape.fingers {
        return Err(Failure::Usage(format!(
            "could not calibrate {device}: it has {} fingertips, but only {} calibrations are \
             left; give --calibration once per fingertip, in the order of the devices",
            shape.fingers,
            calibrations.len()
        )));
    }
    let own: Vec<Calibration> = calibrations.drain(..shape.fingers).collect();
    match own.iter().find(|of| of.elements_in() != shape.taxels) {
        Some(other) => Err(Failure::Usage(format!(
            "could not use the calibration {:?} for {device}: it has {} elements, the sensor has \
             {}; calibrate this sensor",
            other.source,
            other.elements_in(),
            shape.taxels
        ))),
        None if is_zeroed => {
            let own = own.into_iter().map(Calibration::without_zero);
            Ok(Newtons::Fitted(own.collect()))
        }
        None => Ok(Newtons::Fitted(own)),
    }
}

/// Parses one `[[port]]` through the equivalent command line.
fn parse_port(port: &Value, table: &toml::Table) -> Result<Plan, String> {
    let port = port.as_table().ok_or("needs a table")?;
    let name = port.get("sensor").and_then(Value::as_str);
    let sensor = name.and_then(named).ok_or_else(|| {
        let known: Vec<_> = crate::wire::SENSORS
            .iter()
            .map(|sensor| sensor.name)
            .collect();
        format!(
            "could not use sensor = {name:?}, needs one of {}",
            known.join(", ")
        )
    })?;
    let mut line = vec!["atas-sensor".to_owned(), sensor.name.to_owned()];
    let shared = table.iter().filter(|(key, _)| *key != "layout");
    for (key, value) in port
        .iter()
        .filter(|(key, _)| *key != "sensor")
        .chain(shared)
    {
        match value {
            Value::Boolean(false) => {}
            Value::Boolean(true) => line.push(format!("--{key}")),
            Value::String(text) => line.push(format!("--{key}={text}")),
            Value::Array(several) => {
                let text = |value: &Value| value.as_str().map_or(value.to_string(), str::to_owned);
                line.extend(
                    several
                        .iter()
                        .map(|value| format!("--{key}={}", text(value))),
                );
            }
            other => line.push(format!("--{key}={other}")),
        }
    }
    let matches = cli::command()
        .try_get_matches_from(line)
        .map_err(|error| error.to_string())?;
    let (_, matches) = matches.subcommand().ok_or("needs a sensor")?;
    Plan::from_sensor(sensor, matches).map_err(|failure| failure.to_string())
}

fn reject_conflicts(ports: &[Port]) -> Result<(), Failure> {
    let spans: Vec<hand::FingertipRange<'_>> = ports
        .iter()
        .map(|port| hand::FingertipRange {
            device: &port.settings.device,
            finger: port.finger,
            fingers: port.shape().fingers,
        })
        .collect();
    match hand::find_conflict(&spans) {
        Some(reason) => Err(Failure::Usage(reason)),
        None => Ok(()),
    }
}

fn max_elements(ports: &[Port]) -> usize {
    let elements = ports.iter().map(|port| {
        let newtons = port.newtons.as_ref();
        newtons.map_or(port.shape().taxels, |newtons| {
            newtons.elements(port.shape())
        })
    });
    elements.max().unwrap_or(1)
}

/// Returns the named layout, or a pad with `elements` elements.
///
/// # Errors
/// [`Failure::Usage`] if it is unknown or too small.
pub fn layout(wanted: Option<&str>, elements: usize) -> Result<Layout, Failure> {
    if elements > ELEMENTS {
        return Err(Failure::Usage(format!(
            "could not publish {elements} taxels of one fingertip: a frame holds at most \
             {ELEMENTS} elements; reduce them to one force with --calibration (`atas calibrate fit \
             --model resultant`)"
        )));
    }
    let made = format!("pad-{elements}");
    let name = wanted.unwrap_or(&made);
    match Layout::from_name(name) {
        Some(layout) if layout.count >= elements => Ok(layout),
        _ => Err(Failure::Usage(format!(
            "could not use the layout {name}: needs one with at least {elements} elements: {made}, or {}",
            NamedLayout::FORMS
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::{Newtons, Plan};
    use crate::calibration::{Calibration, Model, Quality};
    use crate::cli;
    use crate::wire::{DeviceMessages, named};

    fn plan(line: &str) -> Result<Plan, String> {
        let words = ["atas-sensor", "optoforce", "--device", "/dev/ttyUSB0"]
            .into_iter()
            .chain(line.split_whitespace());
        let matches = cli::command()
            .try_get_matches_from(words)
            .map_err(|error| error.to_string())?;
        let (name, matches) = matches.subcommand().unwrap();
        Plan::from_sensor(named(name).unwrap(), matches).map_err(|error| error.to_string())
    }

    fn normal_n(newtons: &crate::newtons::Newtons, z: f64) -> f32 {
        let mut forces_n = [[0.0; 3]; shm_schemas::capacity::ELEMENTS];
        newtons.write(
            0,
            crate::reading::Quantity::Force,
            &[0.0, 0.0, z],
            &mut forces_n,
        );
        forces_n[0][0]
    }

    #[test]
    fn defaults_configure_and_publish() {
        let plan = plan("--hand left --newtons-per-count 0.1,0.1,0.1").unwrap();
        let dialogue = plan.ports[0].driver.messages();
        assert!(plan.ports[0].settings.configure && dialogue.acknowledged);
        assert_eq!(dialogue.start[4..7], [1, 0, 0]);
        let seat = &plan.slots()[0];
        assert_eq!((seat.finger, normal_n(&seat.newtons, -10.0)), (0, 1.0));
        assert_eq!(plan.destination.unwrap().layout.count, 1);
    }

    #[test]
    fn dry_run_needs_neither_hand_nor_scale() {
        let plan = plan("--dry-run --no-configure --rate-hz 100").unwrap();
        assert!(plan.destination.is_none() && !plan.ports[0].settings.configure);
        assert_eq!(plan.ports[0].settings.period_ns, 10_000_000);
        assert_ne!(plan.ports[0].driver.messages(), DeviceMessages::default());
    }

    #[test]
    fn second_device_covers_the_next_fingertip() {
        let plan = plan("--hand left --newtons-per-count 1,1,1 --finger 1 --device b").unwrap();
        let fingers: Vec<usize> = plan.slots().iter().map(|seat| seat.finger).collect();
        assert_eq!(fingers, [1, 2]);
    }

    /// Regression: `--zero` also subtracted the calibration's zero.
    #[test]
    fn zero_option_replaces_the_calibration_zero() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("tip.toml");
        let calibration = Calibration {
            format: 1,
            source: "a test".to_owned(),
            model: Model::Matrix,
            zero: vec![10.0, 20.0, 30.0],
            newtons: vec![[
                vec![1.0, 0.0, 0.0],
                vec![0.0, 1.0, 0.0],
                vec![0.0, 0.0, 1.0],
            ]],
            quality: Quality::default(),
            drift: None,
        };
        calibration.save(&path).expect("the calibration is written");
        let check = |more: &str, force_n: [f64; 3]| {
            let line = format!("--hand left --calibration {} {more}", path.display());
            let plan = plan(&line).expect("valid arguments");
            let Some(Newtons::Fitted(of)) = &plan.ports[0].newtons else {
                panic!("expected a fitted calibration");
            };
            assert_eq!(of[0].force_n(0, &[11.0, 20.0, 30.0]), force_n, "{more:?}");
        };
        check("", [1.0, 0.0, 0.0]);
        check("--zero", [11.0, 20.0, 30.0]);
    }

    #[test]
    fn contradictory_options_are_rejected_with_a_remedy() {
        let check = |line: &str, cure: &str| {
            let error = plan(line).err().unwrap_or_default();
            assert!(error.contains(cure), "{line}: {error}");
        };
        check("--newtons-per-count 1,1,1", "--hand");
        check("--hand left", "--newtons-per-count");
        check("--hand middle --newtons-per-count 1,1,1", "left or right");
        check("--hand left --newtons-per-count 1,1", "X,Y,Z");
        check(
            "--hand left --newtons-per-count 1,1,1 --axes -z,x,x",
            "-z,x,y",
        );
        check("--dry-run --rate-hz 500", "1000, 333");
        check("--dry-run --filter-hz 20", "0 (none)");
        check("--dry-run --finger 4", "0..4");
        check("--dry-run --finger 1 --channels 4", "--finger 0");
        check("--dry-run --device b", "one --device");
        check("--dry-run --zero --no-configure", "cannot be used with");
        check(
            "--hand left --newtons-per-count 1,1,1 --layout dome",
            "at least 1 elements",
        );
    }
}
