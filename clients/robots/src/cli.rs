//! The command line: what may be said.

use std::path::PathBuf;

use atas_process::file_name::ending_in;
use clap::{Args, Parser, Subcommand, ValueEnum};
use shm_bus::BusName;

const AFTER: &str = "\
Examples:
  atas-robot probe /dev/ttyUSB0
  atas-robot calibrate robot.toml --out calibrated.toml
  atas-robot run calibrated.toml
  atas-robot hz

Exit codes: 0 stopped by SIGINT or SIGTERM, the servos hold; 1 standard output failed; 2 wrong arguments; 3 wrong servo map; \
4 servos do not answer as the map says; 6 bus not usable.
Log: standard error, filtered by RUST_LOG (default info). With --format json an error is one JSON object there: {error, exit}.";

const RUN_HELP: &str = r#"The map, one [[port]] for each serial port, one [[port.servo]] for each joint of the robot:
  robot = "two-hand-arm"            # or a robot file, as the daemon is told

  [[port]]
  device = "/dev/serial/by-id/usb-FTDI_..."
  driver = "dynamixel"              # atas-robot list
  baud = 1000000
  rate_hz = 500                     # most cycles per second; the wire allows fewer
  answer_within_ms = 8

    [[port.servo]]
    joint = "left_wrist_roll"
    id = 5
    model = "xm430-w350"
    direction = 1                   # -1: the shaft turns against the joint
    zero_rad = 3.1416               # the shaft's angle where the joint is at 0 (atas-robot calibrate)
    gear = 1.0                      # turns of the shaft per turn of the joint
    current_limit_a = 0.8           # or torque_limit_percent, as the model limits itself
    temperature_limit_c = 65        # from here on the robot holds
    torque_per_current_n_m_a = 1.8  # of the model's sheet; without it efforts are told as zero

Nothing moves at the start: each servo that is loose gets the place where it stands as its goal, and then torque; one that holds goes \
on holding. At the end all go on holding. To let them go: atas-robot relax.

The daemon must expect joint states as rarely as they come: [intake] hold_age_s of at least three of their periods (atas-robot hz).

Example:
  atas-robot run robot.toml"#;

const LIST_HELP: &str =
    "JSON: {drivers: [{name, about, bauds, models: [{name, number, limited_by, limit_max}]}]}.

Example:
  atas-robot list --format json";

const PROBE_HELP: &str = "JSON: {device, found: [{driver, baud, servos: [{id, model, number}]}]}; empty when nobody answers. A few \
seconds for each line speed; reads only, nothing moves.

Examples:
  atas-robot probe /dev/ttyUSB0
  atas-robot probe /dev/ttyUSB0 --baud 1000000 --format json";

const HZ_HELP: &str = "JSON, one object per second: {states, lost, rate_hz, period_ms: {min, mean, max}, age_ms: {min, mean, max}}; null \
where nothing came. The age of a state is from the question to the servos until it is read here.

Examples:
  atas-robot hz
  atas-robot hz --seconds 5 --format json";

const CALIBRATE_HELP: &str = "For each joint, guided on standard error: it is let go, you put it to 0, then move it a little in its positive \
direction. Prints the map with the zeros and directions that were found. Support what hangs on the joint.

Example:
  atas-robot calibrate robot.toml --joint left_wrist_roll --out calibrated.toml";

const RELAX_HELP: &str =
    "What the robot holds it drops, and arms fall: support them. Asks nothing if --yes is given.

Example:
  atas-robot relax robot.toml --joint left_wrist_roll --yes";

const EMULATE_HELP: &str = "Plays the servos of a map behind pseudo-terminals, in the middle of their joints' travel, with the time that their bytes \
would need on the wire; writes the same map with those terminals. Runs until it is stopped. JSON: {map, ports: [{device, servos}]}.

Example:
  atas-robot emulate robot.toml --out emulated.toml &
  atas-robot run emulated.toml";

/// Drives real servos as the daemon's robot.
#[derive(Debug, Parser)]
#[command(name = "atas-robot", version, after_help = AFTER, arg_required_else_help = true)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub verb: Verb,
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

/// Everything that it can do.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Drive the servos of a map: joint states out, commands in.
    #[command(after_help = RUN_HELP)]
    Run {
        /// Which servo moves which joint, in TOML.
        map: PathBuf,
        /// Bus of the daemon.
        #[arg(long, env = "ATAS_BUS", default_value = "atas")]
        bus: BusName,
        /// Wait for servos that do not answer at the start.
        #[arg(long)]
        wait: bool,
    },
    /// The servos that can be driven.
    #[command(after_help = LIST_HELP)]
    List {
        /// How to print.
        #[arg(long, value_enum, default_value = "text")]
        format: Format,
    },
    /// Which servos are on this port?
    #[command(after_help = PROBE_HELP)]
    Probe {
        /// Path of the terminal.
        device: String,
        /// Only at this line speed.
        #[arg(long)]
        baud: Option<u32>,
        /// How to print.
        #[arg(long, value_enum, default_value = "text")]
        format: Format,
    },
    /// How fast joint states come over the bus.
    #[command(after_help = HZ_HELP)]
    Hz {
        /// Bus to listen on.
        #[arg(long, env = "ATAS_BUS", default_value = "atas")]
        bus: BusName,
        /// Stop after so many seconds.
        #[arg(long)]
        seconds: Option<u64>,
        /// How to print.
        #[arg(long, value_enum, default_value = "text")]
        format: Format,
    },
    /// Find zeros and directions, joint by joint.
    #[command(after_help = CALIBRATE_HELP)]
    Calibrate {
        /// Which joints.
        #[command(flatten)]
        which: Which,
        /// Where to write the map, instead of standard output.
        #[arg(long, value_name = "FILE.toml", value_parser = map_file)]
        out: Option<PathBuf>,
    },
    /// Let servos go: switch their torque off.
    #[command(after_help = RELAX_HELP)]
    Relax {
        /// Which joints.
        #[command(flatten)]
        which: Which,
        /// Do not ask.
        #[arg(long)]
        yes: bool,
    },
    /// Play the servos of a map, for who has none yet.
    #[command(after_help = EMULATE_HELP)]
    Emulate {
        /// The map.
        map: PathBuf,
        /// Where to write the map with the terminals.
        #[arg(long, value_name = "FILE.toml", value_parser = map_file)]
        out: PathBuf,
        /// How to print.
        #[arg(long, value_enum, default_value = "text")]
        format: Format,
    },
    /// Print completions for a shell.
    #[command(
        after_help = "Example:\n  atas-robot completions bash > /etc/bash_completion.d/atas-robot"
    )]
    Completions {
        /// Which shell.
        shell: clap_complete::Shell,
    },
    /// Write the manual pages into a folder.
    #[command(after_help = "Example:\n  atas-robot man /usr/local/share/man/man1")]
    Man {
        /// The folder; it is made.
        folder: PathBuf,
    },
}

/// A map to write.
fn map_file(text: &str) -> Result<PathBuf, String> {
    ending_in(text, &["toml"])
}

/// Joints of a map.
#[derive(Debug, Args)]
pub struct Which {
    /// The servo map.
    pub map: PathBuf,
    /// Only this joint; may be given several times.
    #[arg(long)]
    pub joint: Vec<String>,
}
