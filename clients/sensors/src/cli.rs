//! Command line: one subcommand per sensor (common options and the sensor's own), and the tools.

use std::path::PathBuf;

use atas_process::exit::Exit;
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

Log: standard error, filtered by RUST_LOG (default info). With --format json an error is one JSON object there: {error, exit}.";

/// Options common to all sensors.
#[derive(Debug, Args)]
pub struct PortArgs {
    /// Terminal, pseudo-terminal, FIFO or address of the device; repeat for further devices on the
    /// next fingertips.
    #[arg(long, required = true, action = ArgAction::Append, value_name = "DEVICE")]
    pub device: Vec<String>,
    /// Hand that carries the sensor: left or right.
    #[arg(long, value_parser = parse_hand, required_unless_present = "dry_run")]
    pub hand: Option<Hand>,
    /// Index of the first fingertip, from 0.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(..FINGERS as i64))]
    pub finger: u32,
    /// Bus to publish on.
    #[arg(long, env = "ATAS_BUS", default_value = "atas")]
    pub bus: BusName,
    /// Layout of the fingertips, as in the daemon's `[hands.left] layout`: dome-41, dome-1, pad-N,
    /// flat-RxC-P or cylinder-RxC-P-Q.
    #[arg(long)]
    pub layout: Option<String>,
    /// Scale X,Y,Z of the unit's data sheet, N per device unit; accepts quotients such as 300/7925.
    #[arg(long, alias = "newtons-per-unit")]
    pub newtons_per_count: Option<Scale>,
    /// Calibration file by `atas calibrate`, replaces scale and axes; repeat once per fingertip in
    /// device order.
    #[arg(long, action = ArgAction::Append, value_name = "FILE")]
    pub calibration: Vec<PathBuf>,
    /// Device axes of the normal force and the two tangential forces.
    #[arg(long, allow_hyphen_values = true)]
    pub axes: Axes,
    /// Requested frame rate, Hz; with --no-configure the actual rate, for time stamps.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub rate_hz: u32,
    /// Take the initial load as zero; do not touch the sensor meanwhile.
    #[arg(long, overrides_with = "no_zero", conflicts_with = "no_configure")]
    pub zero: bool,
    /// Keep the device's zero (default).
    #[arg(long, overrides_with = "zero")]
    pub no_zero: bool,
    /// Only read; do not configure the device.
    #[arg(long)]
    pub no_configure: bool,
    /// Wait for a missing device, and reconnect to a lost one.
    #[arg(long)]
    pub reconnect: bool,
    /// Print frames as comma-separated values instead of publishing; accepts a recording as the
    /// device.
    #[arg(long, action = ArgAction::SetTrue)]
    pub dry_run: bool,
}

/// Output format of a tool.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Readable text.
    #[default]
    Text,
    /// JSON.
    Json,
}

const HAND_HELP: &str = r#"The file:
  hand = "left"
  layout = "pad-31"             # as configured in the daemon; default: fits the largest sensor

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

const PROBE_HELP: &str = "JSON: {device, found: [{name, frames, junk_bytes, rate_hz, needs}]}, \
    best match first; found is empty if no sensor was recognised. On failure {device, error}. A \
    sensor that needs non-default options is listed with these in `needs`.\n\nExamples:\n\x20 \
    atas-sensor probe /dev/ttyUSB0\n\x20 atas-sensor probe ws://127.0.0.1:5000\n\x20 atas-sensor \
    probe 192.168.1.1 --format json";

const HZ_HELP: &str = "JSON, one object per second: {hand, frames, lost, rate_hz, period_ms: {min, \
    mean, max}}; min, mean and max are null without two consecutive frames.\n\nExamples:\n\x20 \
    atas-sensor hz --hand left\n\x20 atas-sensor hz --hand right --seconds 5 --format json";

const ECHO_HELP: &str = "JSON, one object per frame: {hand, sequence, captured_ns, fingers: [{finger, valid, \
force_n: [normal, tangential1, tangential2], taxels_n: [[..]]}]}; force_n is the sum over valid taxels.

Examples:
  atas-sensor echo --hand left
  atas-sensor echo --hand left --frames 100 --format json";

const REPLAY_HELP: &str = "A recording contains sensor frames if the daemon ran with `atasd \
    --record-stream`. Its layout, forces and masks are published unchanged; configure the \
    receiving daemon for them. Lost frames stay lost. Damaged and out-of-order frames are skipped; \
    standard error reports their number at the end. A recording that ends in damage is played up \
    to the damage, then the exit code is 7; repair it with `atas record repair`. Of a table, the \
    columns in newtons are played, and every row counts as valid; set --layout and --fingers as in \
    the daemon.\n\nExamples:\n\x20 atas-sensor replay run.mcap --hand left\n\x20 atas-sensor \
    replay run.mcap run-001.mcap --hand right --speed 0.25\n\x20 atas-sensor replay press.csv \
    --hand left --rate-hz 100 --loop";

/// Options of `replay`.
#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// All files of one `atas record` run in order, or one table of `atas-sensor SENSOR --dry-run`.
    #[arg(required = true, value_name = "RECORDING")]
    pub files: Vec<PathBuf>,
    /// Hand to replay: left or right; a table becomes this hand's.
    #[arg(long, value_parser = parse_hand)]
    pub hand: Hand,
    /// Bus to publish on.
    #[arg(long, env = "ATAS_BUS", default_value = "atas")]
    pub bus: BusName,
    /// Playback speed relative to the recording, 0.01 to 100.
    #[arg(long, default_value_t = 1.0, value_parser = parse_speed, conflicts_with = "rate_hz")]
    pub speed: f64,
    /// Constant frame rate, Hz; replaces the recorded spacing.
    #[arg(long, value_parser = parse_rate)]
    pub rate_hz: Option<f64>,
    /// Restart at the end, until Ctrl-C.
    #[arg(long = "loop")]
    pub repeat: bool,
    /// Layout of a table's fingertips, as in the daemon; default: pad-N for its elements.
    #[arg(long)]
    pub layout: Option<String>,
    /// Fingertips of a table, with equal element counts; default: one.
    #[arg(long, value_parser = parse_fingers)]
    pub fingers: Option<usize>,
}

/// Tools.
#[derive(Debug, Subcommand)]
pub enum Tool {
    /// Read several devices of one hand, of one or several sensor types.
    #[command(after_help = HAND_HELP)]
    Hand {
        /// TOML file that lists the devices.
        file: PathBuf,
    },
    /// List the supported sensors.
    #[command(after_help = LIST_HELP)]
    List {
        /// Output format.
        #[arg(long, value_enum, default_value = "text")]
        format: Format,
    },
    /// Identify the sensor on a port.
    #[command(after_help = PROBE_HELP)]
    Probe {
        /// Terminal or address.
        device: String,
        /// Output format.
        #[arg(long, value_enum, default_value = "text")]
        format: Format,
    },
    /// Measure the frame rate of a hand on the bus.
    #[command(after_help = HZ_HELP)]
    Hz {
        /// Bus and hand.
        #[command(flatten)]
        bus_args: BusArgs,
        /// Stop after this number of seconds.
        #[arg(long)]
        seconds: Option<u64>,
    },
    /// Print the forces of a hand, frame by frame, from the bus.
    #[command(after_help = ECHO_HELP)]
    Echo {
        /// Bus and hand.
        #[command(flatten)]
        bus_args: BusArgs,
        /// Stop after this number of frames.
        #[arg(long)]
        frames: Option<u64>,
    },
    /// Publish the frames of a recording on the bus.
    #[command(after_help = REPLAY_HELP)]
    Replay(ReplayArgs),
    /// Print completions for a shell.
    #[command(
        after_help = "Example:\n  atas-sensor completions bash > /etc/bash_completion.d/atas-sensor"
    )]
    Completions {
        /// Shell.
        shell: clap_complete::Shell,
    },
    /// Write the manual pages into a folder.
    #[command(after_help = "Example:\n  atas-sensor man /usr/local/share/man/man1")]
    Man {
        /// Output folder; it is created if missing.
        folder: PathBuf,
    },
}

/// Bus and hand that a tool reads.
#[derive(Debug, Args)]
pub struct BusArgs {
    /// Hand to read: left or right.
    #[arg(long, value_parser = parse_hand)]
    pub hand: Hand,
    /// Bus to join.
    #[arg(long, env = "ATAS_BUS", default_value = "atas")]
    pub bus: BusName,
    /// Output format.
    #[arg(long, value_enum, default_value = "text")]
    pub format: Format,
}

/// Returns the whole command line.
#[must_use]
pub fn command() -> Command {
    let command = SENSORS
        .iter()
        .fold(Command::new("atas-sensor"), |command, sensor| {
            command.subcommand(subcommand(sensor))
        });
    // This call replaces the description, so it must precede `about`.
    Tool::augment_subcommands(command)
        .version(env!("CARGO_PKG_VERSION"))
        .long_version(shm_bus::long_version())
        .about("Reads real tactile sensors and publishes their frames")
        .after_help(format!("{AFTER}\n\n{}", Exit::TABLE))
        .subcommand_required(true)
        .arg_required_else_help(true)
}

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
    // This call replaces the description, so it must precede `about`.
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
