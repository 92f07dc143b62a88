//! The command line: what may be said, and what it amounts to.

use std::path::PathBuf;

use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum};
use shm_bus::BusName;
use shm_schemas::Hand;
use shm_schemas::capacity::FINGERS;

use crate::driver::Settings;
use crate::failure::Failure;
use crate::mapping::{Axes, Mapping, Scale};
use crate::wire::optoforce::{Configuration, Filter, Kind, Speed};

/// Reads a real tactile sensor and publishes what it feels.
#[derive(Debug, Parser)]
#[command(name = "atas-sensor", version, after_help = EXIT_CODES)]
pub struct Cli {
    /// Which sensor.
    #[command(subcommand)]
    pub sensor: Sensor,
}

const EXIT_CODES: &str = "Exit codes: 0 stopped by SIGINT or SIGTERM, or end of a recording; 1 standard output failed; \
2 wrong arguments; 3 device not opened; 4 device does not answer as configured; 5 device lost; 6 bus not usable.\n\
Log: standard error, filtered by RUST_LOG (default info).";

const BURSTS: &str = "If frames come in bursts of 16: a USB bridge collects them. Write 1 to \
/sys/bus/usb-serial/devices/ttyUSB0/latency_timer.";

/// The sensors that can be read.
#[derive(Debug, Subcommand)]
pub enum Sensor {
    /// OptoForce / OnRobot OMD three-axis domes and six-axis sensors on a serial port.
    Optoforce(OptoforceArgs),
}

/// What the device sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Channels {
    /// One three-axis dome.
    #[value(name = "1")]
    One,
    /// Four three-axis domes on one converter: dome i is finger i.
    #[value(name = "4")]
    Four,
    /// One six-axis sensor; the bus carries its force, the dry run also its torque.
    SixAxis,
}

/// Arguments of `atas-sensor optoforce`.
#[derive(Debug, Args)]
#[command(after_help = BURSTS)]
pub struct OptoforceArgs {
    /// Terminal of the device, for example /dev/ttyUSB0; a pseudo-terminal or a FIFO works too.
    #[arg(long)]
    device: PathBuf,
    /// Hand that wears the sensor.
    #[arg(long, value_parser = parse_hand, required_unless_present = "dry_run")]
    hand: Option<Hand>,
    /// Finger of that hand, counted from 0.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(..FINGERS as i64))]
    finger: u32,
    /// Bus to publish on.
    #[arg(long, env = "ATAS_BUS", default_value = "atas")]
    bus: BusName,
    /// What the device sends.
    #[arg(long, value_enum, default_value = "1")]
    channels: Channels,
    /// Scale X,Y,Z from the unit's own sheet, N per count; quotients such as 300/7925 are allowed.
    #[arg(long, required_unless_present = "dry_run")]
    newtons_per_count: Option<Scale>,
    /// Which of the device's axes give the normal force and the two tangential forces.
    #[arg(long, default_value = "-z,x,y", allow_hyphen_values = true)]
    axes: Axes,
    /// Frames per second: 1000, 333, 100, 30 or 10. With --no-configure: what the stream has, for its time stamps.
    #[arg(long, default_value_t = 1000)]
    rate_hz: u32,
    /// Low-pass of the device, Hz: 500, 150, 50, 15, 5, 1.5, or 0 for none.
    #[arg(long, default_value_t = 0.0)]
    filter_hz: f64,
    /// Take the load at the start as zero. Do not touch the sensor then.
    #[arg(long, overrides_with = "no_zero", conflicts_with = "no_configure")]
    zero: bool,
    /// Keep the device's zero (default).
    #[arg(long, overrides_with = "zero")]
    no_zero: bool,
    /// Only read: send the device neither configuration nor stop.
    #[arg(long)]
    no_configure: bool,
    /// Wait for a device that is missing, and again when it goes away.
    #[arg(long)]
    reconnect: bool,
    /// Print every frame as comma-separated values instead of publishing; a recording may be given as the device.
    #[arg(long, action = ArgAction::SetTrue)]
    dry_run: bool,
}

/// Where readings go on the bus.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Name of the bus.
    pub bus: BusName,
    /// The hand.
    pub hand: Hand,
    /// The finger of the first channel.
    pub finger: usize,
    /// From counts to newtons.
    pub mapping: Mapping,
}

/// Arguments that were checked against each other.
#[derive(Debug)]
pub struct Resolved {
    /// How to run the device.
    pub settings: Settings,
    /// How counts become newtons, where that is known.
    pub mapping: Option<Mapping>,
    /// Where to publish; `None` in a dry run.
    pub place: Option<Place>,
}

impl OptoforceArgs {
    /// Checks the arguments against each other.
    ///
    /// # Errors
    /// [`Failure::Usage`] with a sentence that says what is wrong.
    pub fn resolve(self) -> Result<Resolved, Failure> {
        let kind = self.channels.kind();
        let speed = Speed::from_hz(self.rate_hz)
            .map_err(|e| Failure::Usage(format!("could not use --rate-hz: {e}")))?;
        let filter = Filter::from_hz(self.filter_hz)
            .map_err(|e| Failure::Usage(format!("could not use --filter-hz: {e}")))?;
        let finger = self.finger as usize;
        if finger + kind.channel_count() > FINGERS {
            return Err(Failure::Usage(format!(
                "could not place {} channels from --finger {finger}: a hand has {FINGERS} fingers; use --finger 0",
                kind.channel_count(),
            )));
        }
        let mapping = self.newtons_per_count.map(|scale| Mapping {
            scale,
            axes: self.axes,
        });
        let place = match (self.dry_run, self.hand, mapping) {
            (false, Some(hand), Some(mapping)) => Some(Place {
                bus: self.bus,
                hand,
                finger,
                mapping,
            }),
            _ => None,
        };
        let settings = Settings {
            device: self.device,
            configuration: (!self.no_configure).then_some(Configuration {
                speed,
                filter,
                zero: self.zero,
            }),
            kind,
            period_ns: speed.period_ns(),
            recording_allowed: self.dry_run,
            reconnect: self.reconnect,
        };
        Ok(Resolved {
            settings,
            mapping,
            place,
        })
    }
}

impl Channels {
    fn kind(self) -> Kind {
        match self {
            Self::One => Kind::OneChannel,
            Self::Four => Kind::FourChannel,
            Self::SixAxis => Kind::SixAxis,
        }
    }
}

fn parse_hand(text: &str) -> Result<Hand, String> {
    Hand::from_name(text).ok_or_else(|| "needs left or right".to_owned())
}

#[cfg(test)]
mod tests {
    use super::{Cli, Sensor};
    use clap::{CommandFactory, Parser};

    fn resolve(line: &str) -> Result<super::Resolved, String> {
        let words = ["atas-sensor", "optoforce", "--device", "/dev/ttyUSB0"]
            .into_iter()
            .chain(line.split_whitespace());
        let Sensor::Optoforce(args) = Cli::try_parse_from(words)
            .map_err(|e| e.to_string())?
            .sensor;
        args.resolve().map_err(|e| e.to_string())
    }

    #[test]
    fn the_definition_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn defaults_configure_and_publish() {
        let resolved = resolve("--hand left --newtons-per-count 0.1,0.1,0.1").unwrap();
        let configuration = resolved.settings.configuration.unwrap();
        assert_eq!(configuration.to_bytes()[4..7], [1, 0, 0]);
        let place = resolved.place.unwrap();
        assert_eq!(
            (place.finger, place.mapping.force_n([0, 0, -10])[0]),
            (0, 1.0)
        );
    }

    #[test]
    fn a_dry_run_needs_neither_hand_nor_scale() {
        let resolved = resolve("--dry-run --no-configure --rate-hz 100").unwrap();
        assert!(resolved.place.is_none() && resolved.settings.configuration.is_none());
        assert_eq!(resolved.settings.period_ns, 10_000_000);
    }

    #[test]
    fn contradictions_are_refused_with_a_cure() {
        let check = |line: &str, cure: &str| {
            let error = resolve(line).unwrap_err();
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
        check("--dry-run --zero --no-configure", "cannot be used with");
    }
}
