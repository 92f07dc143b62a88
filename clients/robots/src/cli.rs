//! Command line of `atas-robot`.

use std::path::PathBuf;

use atas_process::exit::Exit;
use atas_process::file_name::parse_with_suffix;
use clap::{Args, Parser, Subcommand, ValueEnum};
use shm_bus::BusName;

const AFTER: &str = "\
Examples:
  atas-robot probe /dev/ttyUSB0
  atas-robot calibrate robot.toml --out calibrated.toml
  atas-robot run calibrated.toml
  atas-robot hz

Log: standard error, filtered by RUST_LOG (default info). With --format json, an error is one JSON object on standard error: {error, exit}.";

const RUN_HELP: &str = r#"The map has one [[port]] per serial port and one [[port.servo]] per joint of the robot:
  robot = "two-hand-arm"            # or a robot file, as configured in the daemon

  [[port]]
  device = "/dev/serial/by-id/usb-FTDI_..."
  driver = "dynamixel"              # see atas-robot list
  baud = 1000000
  rate_hz = 500                     # maximum cycles per second; the wire may limit it further
  answer_within_ms = 8

    [[port.servo]]
    joint = "left_wrist_roll"
    id = 5
    model = "xm430-w350"
    direction = 1                   # -1: shaft and joint turn in opposite directions
    zero_rad = 3.1416               # shaft angle at joint position 0 (atas-robot calibrate)
    gear = 1.0                      # shaft turns per joint turn
    current_limit_a = 0.8           # or torque_limit_percent, depending on the model
    temperature_limit_c = 65        # above it the robot holds
    torque_per_current_n_m_a = 1.8  # from the datasheet; without it, efforts are reported as zero

Nothing moves at the start: a servo without torque gets its current position as goal and then torque; a servo with torque keeps its
goal. At the end all servos keep holding. To switch their torque off: atas-robot relax.

The daemon must tolerate the rate of the joint states: set [intake] hold_age_s to at least three periods (atas-robot hz).

Example:
  atas-robot run robot.toml"#;

const LIST_HELP: &str =
    "JSON: {drivers: [{name, about, bauds, models: [{name, number, limited_by, limit_max}]}]}.

Example:
  atas-robot list --format json";

const PROBE_HELP: &str = "JSON: {device, found: [{driver, baud, servos: [{id, model, number}]}]}; empty without a reply. Takes a few \
seconds per line speed. Only reads; nothing moves.

Examples:
  atas-robot probe /dev/ttyUSB0
  atas-robot probe /dev/ttyUSB0 --baud 1000000 --format json";

const HZ_HELP: &str = "JSON, one object per second: {states, lost, rate_hz, period_ms: {min, mean, max}, age_ms: {min, mean, max}}; null \
without states. The age of a state is the time from the request to the servos to its reception here.

Examples:
  atas-robot hz
  atas-robot hz --seconds 5 --format json";

const CALIBRATE_HELP: &str = "For each joint, prompts on standard error guide you: the torque is switched off, you move the joint to 0, then slightly in its \
positive direction. Prints the map with the determined zeros and directions. Support everything that the joint carries.

Example:
  atas-robot calibrate robot.toml --joint left_wrist_roll --out calibrated.toml";

const RELAX_HELP: &str =
    "The robot drops held objects and its arms fall: support them. Asks for confirmation unless --yes is given.

Example:
  atas-robot relax robot.toml --joint left_wrist_roll --yes";

const EMULATE_HELP: &str = "Emulates the servos of a map behind pseudo-terminals, in the middle of their joints' travel or with --rest in the reference \
posture, with the transmission time of the wire. Writes the map with those terminals. Runs until it is stopped. JSON: {map, ports: [{device, servos}]}.

Example:
  atas-robot emulate robot.toml --out emulated.toml &
  atas-robot run emulated.toml";

/// Drives real servos as the daemon's robot.
#[derive(Debug, Parser)]
#[command(name = "atas-robot", version, long_version = shm_bus::long_version(), after_help = format!("{AFTER}\n\n{}", Exit::TABLE), arg_required_else_help = true)]
pub struct Arguments {
    /// Subcommand.
    #[command(subcommand)]
    pub verb: Verb,
}

/// Output format.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Text for users.
    #[default]
    Text,
    /// JSON for programs.
    Json,
}

/// Subcommands.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Drive the servos of a map: publish joint states, execute commands.
    #[command(after_help = RUN_HELP)]
    Run {
        /// Servo map (TOML).
        map: PathBuf,
        /// Bus of the daemon.
        #[arg(long, env = "ATAS_BUS", default_value = "atas")]
        bus: BusName,
        /// Wait for servos that do not reply at the start.
        #[arg(long)]
        wait: bool,
    },
    /// List the supported servos.
    #[command(after_help = LIST_HELP)]
    List {
        /// Output format.
        #[arg(long, value_enum, default_value = "text")]
        format: Format,
    },
    /// Find the servos on a serial port.
    #[command(after_help = PROBE_HELP)]
    Probe {
        /// Path of the serial port.
        device: String,
        /// Try only this line speed.
        #[arg(long)]
        baud: Option<u32>,
        /// Output format.
        #[arg(long, value_enum, default_value = "text")]
        format: Format,
    },
    /// Show rate and age of joint states on the bus.
    #[command(after_help = HZ_HELP)]
    Hz {
        /// Bus of the daemon.
        #[arg(long, env = "ATAS_BUS", default_value = "atas")]
        bus: BusName,
        /// Stop after this number of seconds.
        #[arg(long)]
        seconds: Option<u64>,
        /// Output format.
        #[arg(long, value_enum, default_value = "text")]
        format: Format,
    },
    /// Determine zeros and directions, joint by joint.
    #[command(after_help = CALIBRATE_HELP)]
    Calibrate {
        /// Selected joints.
        #[command(flatten)]
        which: Which,
        /// Write the map to this file instead of standard output.
        #[arg(long, value_name = "FILE.toml", value_parser = map_file)]
        out: Option<PathBuf>,
    },
    /// Switch the torque of servos off.
    #[command(after_help = RELAX_HELP)]
    Relax {
        /// Selected joints.
        #[command(flatten)]
        which: Which,
        /// Do not ask for confirmation.
        #[arg(long)]
        yes: bool,
    },
    /// Emulate the servos of a map, without hardware.
    #[command(after_help = EMULATE_HELP)]
    Emulate {
        /// Servo map (TOML).
        map: PathBuf,
        /// Write the map with the emulated terminals to this file.
        #[arg(long, value_name = "FILE.toml", value_parser = map_file)]
        out: PathBuf,
        /// Begin in the reference posture of the robot file (`rest_deg`, `rest_m`).
        #[arg(long)]
        rest: bool,
        /// Output format.
        #[arg(long, value_enum, default_value = "text")]
        format: Format,
    },
    /// Print completions for a shell.
    #[command(
        after_help = "Example:\n  atas-robot completions bash > /etc/bash_completion.d/atas-robot"
    )]
    Completions {
        /// Shell.
        shell: clap_complete::Shell,
    },
    /// Write the manual pages into a folder.
    #[command(after_help = "Example:\n  atas-robot man /usr/local/share/man/man1")]
    Man {
        /// Target folder; created if missing.
        folder: PathBuf,
    },
}

/// Parses the path of a map to write.
fn map_file(text: &str) -> Result<PathBuf, String> {
    parse_with_suffix(text, &["toml"])
}

/// Selection of joints of a map.
#[derive(Debug, Args)]
pub struct Which {
    /// Servo map (TOML).
    pub map: PathBuf,
    /// Only this joint; repeatable.
    #[arg(long)]
    pub joint: Vec<String>,
}
