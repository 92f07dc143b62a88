//! What a command line amounts to: which ports to read, how, and where their readings go.

use std::path::Path;

use clap::{ArgMatches, FromArgMatches};
use shm_schemas::Layout;
use shm_schemas::capacity::ELEMENTS;
use shm_schemas::layout::NamedLayout;
use toml::Value;

use crate::calibration::Calibration;
use crate::cli::{self, PortArgs};
use crate::failure::Failure;
use crate::hand::{self, Place, Seat};
use crate::mapping::Mapping;
use crate::newtons::Newtons;
use crate::port::Settings;
use crate::reading::Shape;
use crate::wire::{Driver, Request, SensorType, Zero, named};

/// One device to read.
pub struct Port {
    /// The kind of sensor.
    pub sensor: &'static SensorType,
    /// How to run it.
    pub settings: Settings,
    /// Its driver.
    pub driver: Box<dyn Driver>,
    /// From its units to newtons, where that is known.
    pub newtons: Option<Newtons>,
    /// The finger of its first fingertip.
    pub finger: usize,
}

/// Devices to read, and where to.
pub struct Plan {
    /// The devices.
    pub ports: Vec<Port>,
    /// Where to publish; `None` in a dry run.
    pub place: Option<Place>,
}

impl Port {
    /// What its frames hold.
    #[must_use]
    pub fn shape(&self) -> Shape {
        self.driver.shape()
    }
}

impl Plan {
    /// From the subcommand of one sensor.
    ///
    /// # Errors
    /// [`Failure::Usage`] with a sentence that says what is wrong.
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
        refuse_conflicts(&ports)?;
        let place = match (args.dry_run, args.hand) {
            (false, Some(hand)) => Some(Place {
                bus: args.bus,
                hand,
                layout: layout(args.layout.as_deref(), elements(&ports))?,
            }),
            _ => None,
        };
        Ok(Self { ports, place })
    }

    /// From a file that describes a hand.
    ///
    /// # Errors
    /// [`Failure::Usage`] with the file and a sentence that says what is wrong.
    pub fn from_file(path: &Path) -> Result<Self, Failure> {
        let refuse =
            |reason: String| Failure::Usage(format!("could not read {}: {reason}", path.display()));
        let text = std::fs::read_to_string(path).map_err(|error| refuse(error.to_string()))?;
        Self::from_toml(&text).map_err(|reason| refuse(reason.to_string()))
    }

    /// From the text of such a file.
    ///
    /// # Errors
    /// A sentence that says what is wrong.
    pub fn from_toml(text: &str) -> Result<Self, Failure> {
        let mut table: toml::Table = text
            .parse()
            .map_err(|error: toml::de::Error| Failure::Usage(error.to_string()))?;
        let ports = table.remove("port");
        let Some(Value::Array(ports)) =
            ports.filter(|ports| !matches!(ports, Value::Array(a) if a.is_empty()))
        else {
            return Err(Failure::Usage(
                "it names no [[port]], needs one or more".to_owned(),
            ));
        };
        if let Some(key) = table
            .keys()
            .find(|key| !["hand", "bus", "layout"].contains(&key.as_str()))
        {
            return Err(Failure::Usage(format!(
                "it has the key {key:?}, needs hand, bus, layout and [[port]]"
            )));
        }
        let mut plan = Self {
            ports: Vec::new(),
            place: None,
        };
        for (n, port) in ports.iter().enumerate() {
            let one = one_port(port, &table)
                .map_err(|reason| Failure::Usage(format!("[[port]] {}: {reason}", n + 1)))?;
            plan.ports.extend(one.ports);
            plan.place = plan.place.or(one.place);
        }
        refuse_conflicts(&plan.ports)?;
        if let Some(place) = &mut plan.place {
            let wanted = table.get("layout").and_then(Value::as_str);
            place.layout = layout(wanted, elements(&plan.ports))?;
        }
        Ok(plan)
    }

    /// The seats of the ports; of all it is known how they become newtons when there is a place.
    #[must_use]
    pub fn seats(&self) -> Vec<Seat> {
        let seat = |port: &Port| {
            Some(Seat {
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
        way: sensor.way,
        period_ns: 1_000_000_000 / u64::from(args.rate_hz.max(1)),
        configure: !args.no_configure,
        tare: args.zero && sensor.zero == Zero::Here,
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
        Some(fitted(driver.shape(), device, calibrations, args.zero)?)
    };
    Ok(Port {
        sensor,
        settings,
        driver,
        newtons,
        finger,
    })
}

/// The calibrations that were named, one per fingertip of all devices.
fn calibrations(args: &PortArgs) -> Result<Vec<Calibration>, Failure> {
    args.calibration
        .iter()
        .map(|path| Calibration::open(path).map_err(|error| Failure::Usage(error.to_string())))
        .collect()
}

/// Takes the next device's calibrations. A device whose zero is taken at the start has no other.
fn fitted(
    shape: Shape,
    device: &str,
    calibrations: &mut Vec<Calibration>,
    is_zeroed: bool,
) -> Result<Newtons, Failure> {
    if calibrations.len() < shape.fingers {
        return Err(Failure::Usage(format!(
            "could not calibrate {device}: it has {} fingertips and {} calibrations are left; give --calibration once per \
             fingertip, in the order of the devices",
            shape.fingers,
            calibrations.len()
        )));
    }
    let own: Vec<Calibration> = calibrations.drain(..shape.fingers).collect();
    match own.iter().find(|of| of.elements_in() != shape.taxels) {
        Some(other) => Err(Failure::Usage(format!(
            "could not use {:?} for {device}: it is of {} elements, the sensor has {}; calibrate it",
            other.source,
            other.elements_in(),
            shape.taxels
        ))),
        None if is_zeroed => {
            let own = own.into_iter().map(Calibration::of_zeroed);
            Ok(Newtons::Fitted(own.collect()))
        }
        None => Ok(Newtons::Fitted(own)),
    }
}

/// One `[[port]]` of a file, by way of the command line that says the same.
fn one_port(port: &Value, table: &toml::Table) -> Result<Plan, String> {
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

fn refuse_conflicts(ports: &[Port]) -> Result<(), Failure> {
    let spans: Vec<hand::Span<'_>> = ports
        .iter()
        .map(|port| hand::Span {
            device: &port.settings.device,
            finger: port.finger,
            fingers: port.shape().fingers,
        })
        .collect();
    match hand::conflict(&spans) {
        Some(reason) => Err(Failure::Usage(reason)),
        None => Ok(()),
    }
}

/// Elements of the largest sensor.
fn elements(ports: &[Port]) -> usize {
    let elements = ports.iter().map(|port| {
        let newtons = port.newtons.as_ref();
        newtons.map_or(port.shape().taxels, |newtons| {
            newtons.elements(port.shape())
        })
    });
    elements.max().unwrap_or(1)
}

/// The layout that was named, or one that is made for so many elements.
///
/// # Errors
/// [`Failure::Usage`] when it has no place for them.
pub fn layout(wanted: Option<&str>, elements: usize) -> Result<Layout, Failure> {
    if elements > ELEMENTS {
        return Err(Failure::Usage(format!(
            "could not publish {elements} taxels of one fingertip: a frame has {ELEMENTS} elements; make one force of them with \
             --calibration (`atas calibrate fit --model resultant`)"
        )));
    }
    let made = format!("pad-{elements}");
    let name = wanted.unwrap_or(&made);
    match Layout::named(name) {
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
    use crate::wire::{Dialogue, named};

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

    /// Normal force of the first element under this z of the device, N.
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
        let dialogue = plan.ports[0].driver.dialogue();
        assert!(plan.ports[0].settings.configure && dialogue.acknowledged);
        assert_eq!(dialogue.start[4..7], [1, 0, 0]);
        let seat = &plan.seats()[0];
        assert_eq!((seat.finger, normal_n(&seat.newtons, -10.0)), (0, 1.0));
        assert_eq!(plan.place.unwrap().layout.count, 1);
    }

    #[test]
    fn a_dry_run_needs_neither_hand_nor_scale() {
        let plan = plan("--dry-run --no-configure --rate-hz 100").unwrap();
        assert!(plan.place.is_none() && !plan.ports[0].settings.configure);
        assert_eq!(plan.ports[0].settings.period_ns, 10_000_000);
        assert_ne!(plan.ports[0].driver.dialogue(), Dialogue::default());
    }

    #[test]
    fn a_further_device_feels_for_the_next_finger() {
        let plan = plan("--hand left --newtons-per-count 1,1,1 --finger 1 --device b").unwrap();
        let fingers: Vec<usize> = plan.seats().iter().map(|seat| seat.finger).collect();
        assert_eq!(fingers, [1, 2]);
    }

    /// Regression: with `--zero` the zero of the calibration was taken off as well.
    #[test]
    fn a_sensor_has_one_zero() {
        let folder = tempfile::tempdir().expect("a folder");
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
        calibration.save(&path).expect("written");
        let check = |more: &str, force_n: [f64; 3]| {
            let line = format!("--hand left --calibration {} {more}", path.display());
            let plan = plan(&line).expect("it holds");
            let Some(Newtons::Fitted(of)) = &plan.ports[0].newtons else {
                panic!("calibrated");
            };
            assert_eq!(of[0].force_n(0, &[11.0, 20.0, 30.0]), force_n, "{more:?}");
        };
        check("", [1.0, 0.0, 0.0]);
        check("--zero", [11.0, 20.0, 30.0]);
    }

    #[test]
    fn contradictions_are_refused_with_a_cure() {
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
