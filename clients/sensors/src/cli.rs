//! The command line: what may be said.
//!
//! One subcommand per sensor, made of the options that all have in common and of the sensor's own; and the tools.

use std::path::PathBuf;

use clap::{ArgAction, Args, Command, Subcommand, ValueEnum};
use shm_bus::BusName;
use shm_schemas::Hand;
use shm_schemas::capacity::FINGERS;

use crate::mapping::{Axes, Scale};
use crate::wire::{SENSORS, SensorType};

const AFTER: &str = "\
Examples:
  atas-sensor probe /dev/ttyUSB0
  atas-sensor optoforce --device /dev/ttyUSB0 --dry-run
  atas-sensor optoforce --device /dev/ttyUSB0 --hand left --newtons-per-count 300/7925,300/8641,2000/6049
  atas-sensor anyskin --device /dev/ttyACM0 --hand left --calibration tip.toml
  atas-sensor hand left.toml
  atas-sensor hz --hand left
  atas-sensor replay run.mcap --hand left

Exit codes: 0 stopped by SIGINT or SIGTERM, or end of a recording; 1 standard output failed; \
2 wrong arguments; 3 device or recording not opened; 4 device does not answer as configured; 5 device lost or recording damaged; \
6 bus not usable.
Log: standard error, filtered by RUST_LOG (default info). With --format json an error is one JSON object there: {error, exit}.";

/// What all sensors' subcommands take.
#[derive(Debug, Args)]
pub struct PortArgs {
    /// Terminal of the device (a pseudo-terminal or a FIFO works too), or its address. Given several times, each further
    /// device feels for the next fingers.
    #[arg(long, required = true, action = ArgAction::Append, value_name = "DEVICE")]
    pub device: Vec<String>,
    /// Hand that wears the sensor: left or right.
    #[arg(long, value_parser = parse_hand, required_unless_present = "dry_run")]
    pub hand: Option<Hand>,
    /// Finger of that hand, counted from 0.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(..FINGERS as i64))]
    pub finger: u32,
    /// Bus to publish on.
    #[arg(long, env = "ATAS_BUS", default_value = "atas")]
    pub bus: BusName,
    /// Layout of the fingertips, as the daemon is configured: dome-41, dome-1, pad-N, flat-RxC-P or
    /// cylinder-RxC-P-Q (`[hands.left] layout`).
    #[arg(long)]
    pub layout: Option<String>,
    /// Scale X,Y,Z from the unit's own sheet, N per unit of the device; quotients such as 300/7925 are allowed.
    #[arg(long, alias = "newtons-per-unit")]
    pub newtons_per_count: Option<Scale>,
    /// Calibration of the device's fingertip, as `atas calibrate` writes it, instead of a scale and axes. Once per fingertip, in
    /// the order of the devices.
    #[arg(long, action = ArgAction::Append, value_name = "FILE")]
    pub calibration: Vec<PathBuf>,
    /// Which of the device's axes give the normal force and the two tangential forces.
    #[arg(long, allow_hyphen_values = true)]
    pub axes: Axes,
    /// Frames per second that the device is asked for; with --no-configure what the stream has, for its time stamps.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub rate_hz: u32,
    /// Take the load at the start as zero. Do not touch the sensor then.
    #[arg(long, overrides_with = "no_zero", conflicts_with = "no_configure")]
    pub zero: bool,
    /// Keep the device's zero (default).
    #[arg(long, overrides_with = "zero")]
    pub no_zero: bool,
    /// Only read: tell the device nothing.
    #[arg(long)]
    pub no_configure: bool,
    /// Wait for a device that is missing, and again when it goes away.
    #[arg(long)]
    pub reconnect: bool,
    /// Print every frame as comma-separated values instead of publishing; a recording may be given as the device.
    #[arg(long, action = ArgAction::SetTrue)]
    pub dry_run: bool,
}

/// How a tool prints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For people.
    #[default]
    Text,
    /// For programs.
    Json,
}

const HAND_HELP: &str = r#"The file:
  hand = "left"
  layout = "pad-31"             # as the daemon is told; by default made for the largest sensor

  [[port]]
  sensor = "optoforce"          # further keys: the options of `atas-sensor optoforce`
  device = "/dev/ttyUSB0"
  finger = 0
  newtons-per-count = "300/7925,300/8641,2000/6049"

  [[port]]
  sensor = "paxini"
  device = "/dev/ttyUSB1"
  finger = 1

Example:
  atas-sensor hand left.toml"#;

const LIST_HELP: &str = "JSON: {sensors: [{name, about, wire, taxels, rate_hz}]}.

Example:
  atas-sensor list --format json";

const PROBE_HELP: &str = "JSON: {device, found: [{name, frames, junk_bytes, rate_hz, needs}]}, best first; empty when nothing \
was recognised. On failure {device, error}. Sensors that need other options than the default ones are named too, with \
what they need.

Examples:
  atas-sensor probe /dev/ttyUSB0
  atas-sensor probe ws://127.0.0.1:5000
  atas-sensor probe 192.168.1.1 --format json";

const HZ_HELP: &str = "JSON, one object per second: {hand, frames, lost, rate_hz, period_ms: {min, mean, max}}; null \
where nothing came.

Examples:
  atas-sensor hz --hand left
  atas-sensor hz --hand right --seconds 5 --format json";

const ECHO_HELP: &str = "JSON, one object per frame: {hand, sequence, captured_ns, fingers: [{finger, valid, \
force_n: [normal, tangential1, tangential2], taxels_n: [[..]]}]}; force_n is the sum over valid taxels.

Examples:
  atas-sensor echo --hand left
  atas-sensor echo --hand left --frames 100 --format json";

const REPLAY_HELP: &str = "\
A recording holds what its daemon took in if that ran with `atasd --record-stream`; its layout, forces and masks are played as \
they were, and the daemon that feels them must be configured for them. Frames that were lost stay lost, frames that were damaged \
or not newer than all before are left out; standard error says how many at the end. A recording that ends in damage is played as \
far as it can be read, then ends with code 5: `atas record repair` makes a whole one. Of a table the columns in newtons are \
played, every row as if its device had been well; --layout and --fingers are what the daemon is told.

Examples:
  atas-sensor replay run.mcap --hand left
  atas-sensor replay run.mcap run-001.mcap --hand right --speed 0.25
  atas-sensor replay press.csv --hand left --rate-hz 100 --loop";

/// What is played, and how.
#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// Recording of `atas record`, all files of one run in order; or one table of `atas-sensor SENSOR --dry-run`.
    #[arg(required = true, value_name = "RECORDING")]
    pub files: Vec<PathBuf>,
    /// Hand whose frames are played: left or right. A table is played as this hand's.
    #[arg(long, value_parser = parse_hand)]
    pub hand: Hand,
    /// Bus to publish on.
    #[arg(long, env = "ATAS_BUS", default_value = "atas")]
    pub bus: BusName,
    /// How many times as fast as recorded, 0.01 to 100.
    #[arg(long, default_value_t = 1.0, value_parser = parse_speed, conflicts_with = "rate_hz")]
    pub speed: f64,
    /// Frames per second, evenly, whatever the recorded spacing.
    #[arg(long, value_parser = parse_rate)]
    pub rate_hz: Option<f64>,
    /// Begin again at the end, until Ctrl-C.
    #[arg(long = "loop")]
    pub again: bool,
    /// Layout of the fingertips of a table, as the daemon is configured; by default pad-N with as many elements.
    #[arg(long)]
    pub layout: Option<String>,
    /// Fingertips of a table, with equally many elements each; by default one.
    #[arg(long, value_parser = parse_fingers)]
    pub fingers: Option<usize>,
}

/// Everything that is not a sensor.
#[derive(Debug, Subcommand)]
pub enum Tool {
    /// Read several devices as one hand, of one kind or mixed.
    #[command(after_help = HAND_HELP)]
    Hand {
        /// Which devices, in TOML.
        file: PathBuf,
    },
    /// The sensors that can be read.
    #[command(after_help = LIST_HELP)]
    List {
        /// How to print.
        #[arg(long, value_enum, default_value = "text")]
        format: Format,
    },
    /// What is on this port? Listens, asks, and says which sensor answers.
    #[command(after_help = PROBE_HELP)]
    Probe {
        /// Terminal or address.
        device: String,
        /// How to print.
        #[arg(long, value_enum, default_value = "text")]
        format: Format,
    },
    /// How fast a hand's frames come over the bus.
    #[command(after_help = HZ_HELP)]
    Hz {
        /// Where to listen.
        #[command(flatten)]
        at: Listen,
        /// Stop after so many seconds.
        #[arg(long)]
        seconds: Option<u64>,
    },
    /// What a hand feels, frame by frame, from the bus.
    #[command(after_help = ECHO_HELP)]
    Echo {
        /// Where to listen.
        #[command(flatten)]
        at: Listen,
        /// Stop after so many frames.
        #[arg(long)]
        frames: Option<u64>,
    },
    /// Play the frames of a recording onto the bus, as the sensor did.
    #[command(after_help = REPLAY_HELP)]
    Replay(ReplayArgs),
    /// Print completions for a shell.
    #[command(
        after_help = "Example:\n  atas-sensor completions bash > /etc/bash_completion.d/atas-sensor"
    )]
    Completions {
        /// Which shell.
        shell: clap_complete::Shell,
    },
    /// Write the manual pages into a folder.
    #[command(after_help = "Example:\n  atas-sensor man /usr/local/share/man/man1")]
    Man {
        /// The folder; it is made.
        folder: PathBuf,
    },
}

/// Where a tool listens.
#[derive(Debug, Args)]
pub struct Listen {
    /// Hand to listen to: left or right.
    #[arg(long, value_parser = parse_hand)]
    pub hand: Hand,
    /// Bus to listen on.
    #[arg(long, env = "ATAS_BUS", default_value = "atas")]
    pub bus: BusName,
    /// How to print.
    #[arg(long, value_enum, default_value = "text")]
    pub format: Format,
}

/// The whole command line.
#[must_use]
pub fn command() -> Command {
    let command = SENSORS
        .iter()
        .fold(Command::new("atas-sensor"), |command, sensor| {
            command.subcommand(subcommand(sensor))
        });
    // What the program is stands after what is taken in, which brings along what it is itself.
    Tool::augment_subcommands(command)
        .version(env!("CARGO_PKG_VERSION"))
        .about("Reads real tactile sensors and publishes what they feel")
        .after_help(AFTER)
        .subcommand_required(true)
        .arg_required_else_help(true)
}

/// The subcommand of one sensor.
fn subcommand(sensor: &SensorType) -> Command {
    let SensorType {
        name,
        about,
        wire,
        example,
        notes,
        ..
    } = sensor;
    let after = format!("{notes}\n\nWire: {wire}.\n\nExample:\n  atas-sensor {name} {example}");
    // As with the tools: what the sensor is stands last.
    let common = PortArgs::augment_args(Command::new(name))
        .about(*about)
        .after_help(after.trim_start().to_owned())
        .mut_arg("rate_hz", |arg| {
            arg.required(false).default_value(sensor.rate_hz)
        })
        .mut_arg("axes", |arg| arg.required(false).default_value(sensor.axes))
        .mut_arg("newtons_per_count", |arg| match sensor.newtons_per_unit {
            Some(scale) => arg.default_value(scale),
            None => arg.required_unless_present_any(["dry_run", "calibration"]),
        });
    (sensor.options)(common)
}

fn parse_hand(text: &str) -> Result<Hand, String> {
    Hand::from_name(text).ok_or_else(|| "needs left or right".to_owned())
}

fn parse_speed(text: &str) -> Result<f64, String> {
    number_within(text, 0.01, 100.0)
}

fn parse_rate(text: &str) -> Result<f64, String> {
    number_within(text, 0.1, 10_000.0)
}

fn number_within(text: &str, least: f64, most: f64) -> Result<f64, String> {
    let number = text.parse().ok();
    number
        .filter(|number| (least..=most).contains(number))
        .ok_or_else(|| format!("needs a number from {least} to {most}"))
}

fn parse_fingers(text: &str) -> Result<usize, String> {
    let fingers = text.parse().ok();
    fingers
        .filter(|fingers| (1..=FINGERS).contains(fingers))
        .ok_or_else(|| format!("needs a number from 1 to {FINGERS}"))
}
