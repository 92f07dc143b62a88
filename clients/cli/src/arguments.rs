//! The command line: what a user may type, and how it is read.
//!
//! Users type millimetres and degrees; everything behind this file is in SI units. Values are only checked for being
//! numbers here: which of them the robot can do is the daemon's to say, so that there is one place that knows.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Parser, Subcommand, ValueEnum};
use shm_bus::BusName;
use shm_schemas::Hand;

use crate::exit::Exit;
use crate::output::Format;

/// Artificial tactile affordance system: what fingertips feel induces the next movement
#[derive(Debug, Parser)]
#[command(name = "atas", version, after_help = Exit::TABLE, arg_required_else_help = true, disable_help_subcommand = true)]
pub struct Arguments {
    /// How results are printed on standard output
    #[arg(
        long,
        value_enum,
        default_value_t,
        global = true,
        value_name = "FORMAT"
    )]
    pub format: Format,
    /// What to do
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Show a task: starts daemon and simulator on a bus of their own, runs the task, cleans up
    Demo {
        /// Which task
        #[command(subcommand)]
        task: Demo,
    },
    /// Measure a task over many seeded trials, in this process and in virtual time
    Eval {
        /// Which task
        #[command(subcommand)]
        task: Eval,
    },
    /// Grasp an object, lift it and hold it; Ctrl-C cancels
    Grasp(Grasp),
    /// Open a hand where it is and bring it home; Ctrl-C cancels
    Release(Release),
    /// Stop now: the robot keeps its place and its grip until `atas recover`
    #[command(visible_alias = "stop")]
    Estop(BusArgument),
    /// Leave a stop or a hold, if its cause is gone
    Recover(BusArgument),
    /// Show how the daemon and its sensors are
    Status(Status),
    /// Show what happened: modules, touches, steps, modes, warnings
    Events(Events),
    /// Read and change the daemon's parameters
    Param {
        /// What to do with them
        #[command(subcommand)]
        action: Param,
    },
    /// Show how punctual the daemon is: wake-up, frame age, tick by stage, sensor to command
    Latency(Latency),
    /// Record what the daemon takes in and gives out, until Ctrl-C; start it before `atasd --record-stream`
    #[command(args_conflicts_with_subcommands = true)]
    Record {
        /// What to do with a file instead
        #[command(subcommand)]
        action: Option<RecordAction>,
        /// How to record
        #[command(flatten)]
        options: Record,
    },
    /// Run the controller on a recording and compare every command bit for bit; exit code 1 if one differs
    Replay {
        /// The files of one run, in order
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
    },
    /// Name the first tick and field in which two recordings differ, and how both ended; exit code 1 if they do
    Diff {
        /// One recording
        first: PathBuf,
        /// Another
        second: PathBuf,
    },
    /// Check this machine, the bus and the daemon, and say what to do; exit code 1 if anything fails
    Doctor(BusArgument),
    /// Print the completions of a shell
    Completions {
        /// Which shell
        #[arg(value_enum)]
        shell: clap_complete::Shell,
    },
    /// Write the manual pages into a folder
    Man {
        /// The folder
        folder: PathBuf,
    },
}

/// The tasks of `atas demo`.
#[derive(Debug, Subcommand)]
pub enum Demo {
    /// Grasp, lift and hold objects of known physics, and compare what became of them with what physics allows
    Grasp(DemoGrasp),
    /// Let a team of mobile robots carry its object to eight goals, each robot by an evolved behaviour table
    Swarm(DemoSwarm),
}

/// The tasks of `atas eval`.
#[derive(Debug, Subcommand)]
pub enum Eval {
    /// The grasp, over families of objects: mass, friction and stiffness ±20 %, pose ±2 mm and ±5°
    Grasp(EvalGrasp),
}

/// Which bus.
#[derive(Args, Clone, Debug)]
pub struct BusArgument {
    /// Bus of the daemon
    #[arg(long, env = BusName::ENV, default_value_t, value_name = "NAME")]
    pub bus: BusName,
}

/// `atas demo grasp`.
#[derive(Args, Clone, Debug)]
pub struct DemoGrasp {
    /// A built-in object, or the file of one
    #[arg(
        long,
        value_name = "NAME|FILE",
        default_value = "wood",
        conflicts_with = "all"
    )]
    pub object: String,
    /// Every built-in object, one after another
    #[arg(long)]
    pub all: bool,
    /// Seed of the sensors' noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Tick by tick as fast as the machine goes, and the same bits every time
    #[arg(long, conflicts_with = "realtime")]
    pub lockstep: bool,
    /// By the clock at 1 kHz; the default
    #[arg(long)]
    pub realtime: bool,
}

/// `atas demo swarm`.
#[derive(Args, Clone, Debug)]
pub struct DemoSwarm {
    /// A table file of `ebts evolve`, or the table that ships. Field and team are those it was evolved for
    #[arg(long, value_name = "NAME|FILE", default_value = "r3-two-agents")]
    pub table: String,
    /// Frames of the field per second
    #[arg(long, value_name = "HZ", default_value_t = 240, value_parser = clap::value_parser!(u32).range(1..=2000))]
    pub frame_rate_hz: u32,
    /// Frame by frame as fast as the machine goes
    #[arg(long, conflicts_with = "frame_rate_hz")]
    pub lockstep: bool,
    /// Write an animation of the eight trials: one web page that needs nothing else
    #[arg(long, value_name = "FILE")]
    pub replay: Option<PathBuf>,
}

/// `atas eval grasp`.
#[derive(Args, Clone, Debug)]
pub struct EvalGrasp {
    /// Trials of each object: seeds 1 to N
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub seeds: u64,
    /// Scales the noise of the fingertip sensors
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = finite)]
    pub noise: f64,
    /// Frames per second of the fingertip sensors
    #[arg(long, value_name = "HZ", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rate_hz: u32,
    /// Built-in objects or files, separated by commas [default: every built-in object]
    #[arg(long, value_name = "NAME|FILE", value_delimiter = ',')]
    pub objects: Vec<String>,
    /// Threads; 0 for one per core. The numbers do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// `atas grasp`.
#[derive(Args, Clone, Debug)]
pub struct Grasp {
    /// Where the fingertips shall close, metres from the robot's base: x forward, y left, z up
    #[arg(long, value_name = "X,Y,Z", value_parser = position_m, allow_hyphen_values = true)]
    pub at: [f64; 3],
    /// Direction of the closing axis, degrees from x towards y
    #[arg(long, value_name = "DEG", default_value_t = 90.0, value_parser = finite, allow_hyphen_values = true)]
    pub yaw: f64,
    /// Expected width of the object along the closing axis, millimetres
    #[arg(long, value_name = "MM", value_parser = finite, allow_hyphen_values = true)]
    pub width: f64,
    /// How far to lift, millimetres
    #[arg(long, value_name = "MM", default_value_t = LIFT_MM, value_parser = finite, allow_hyphen_values = true)]
    pub lift: f64,
    /// How long to hold before the goal counts as reached, seconds
    #[arg(long, value_name = "S", default_value_t = HOLD_S, value_parser = finite, allow_hyphen_values = true)]
    pub hold: f64,
    /// How the goal is sent
    #[command(flatten)]
    pub sending: Sending,
}

/// `atas release`.
#[derive(Args, Clone, Debug)]
pub struct Release {
    /// How the goal is sent
    #[command(flatten)]
    pub sending: Sending,
}

/// How a goal is sent and followed.
#[derive(Args, Clone, Debug)]
pub struct Sending {
    /// Which hand
    #[arg(long, value_enum, default_value_t = HandName::Right)]
    pub hand: HandName,
    /// Hold the robot if this command dies; without it the goal then goes on to its end
    #[arg(long)]
    pub attached: bool,
    /// Cancel the goal if it takes longer, seconds
    #[arg(long, value_name = "S", value_parser = duration)]
    pub timeout: Option<Duration>,
    /// Which daemon
    #[command(flatten)]
    pub bus: BusArgument,
}

/// `atas status`.
#[derive(Args, Clone, Debug)]
pub struct Status {
    /// Go on, five times a second, until Ctrl-C
    #[arg(long)]
    pub watch: bool,
    /// Which daemon
    #[command(flatten)]
    pub bus: BusArgument,
}

/// `atas events`.
#[derive(Args, Clone, Debug)]
pub struct Events {
    /// Go on with new events, until Ctrl-C
    #[arg(long)]
    pub follow: bool,
    /// Stop after this many events, and wait for them
    #[arg(long, value_name = "N")]
    pub count: Option<u64>,
    /// Which daemon
    #[command(flatten)]
    pub bus: BusArgument,
}

/// `atas latency`.
#[derive(Args, Clone, Debug)]
pub struct Latency {
    /// Go on, once a second, until Ctrl-C
    #[arg(long)]
    pub watch: bool,
    /// Which daemon
    #[command(flatten)]
    pub bus: BusArgument,
}

/// `atas record`.
#[derive(Args, Clone, Debug)]
pub struct Record {
    /// File to make; it must not exist [default: atas-SECONDS.mcap, seconds since 1970]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Go on in another file (FILE-001.mcap, …) when this one is larger, for example 500M
    #[arg(long, value_name = "SIZE", value_parser = bytes)]
    pub max_size: Option<u64>,
    /// Keep this many files and remove the oldest; what was removed cannot be replayed
    #[arg(long, value_name = "N", requires = "max_size", value_parser = clap::value_parser!(u16).range(1..))]
    pub max_files: Option<u16>,
    /// End when all files together are larger, for example 20G
    #[arg(long, value_name = "SIZE", value_parser = bytes)]
    pub disk_budget: Option<u64>,
    /// Which daemon
    #[command(flatten)]
    pub bus: BusArgument,
}

/// `atas record check` and `atas record repair`.
#[derive(Debug, Subcommand)]
pub enum RecordAction {
    /// Say whether a recording is whole; exit code 1 if it is not
    Check {
        /// The recording
        file: PathBuf,
    },
    /// Save what can be read of a recording into a new file
    Repair {
        /// The recording; it is left as it is
        file: PathBuf,
        /// File to make; it must not exist [default: NAME-repaired.mcap]
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
    },
}

/// `atas param`.
#[derive(Debug, Subcommand)]
pub enum Param {
    /// Every parameter with its value, range and meaning
    List(BusArgument),
    /// One parameter's value
    Get {
        /// Its name, for example `grasp.dr_n`
        name: String,
        /// Which daemon
        #[command(flatten)]
        bus: BusArgument,
    },
    /// Change one parameter until the daemon restarts
    Set {
        /// Its name, for example `grasp.dr_n`
        name: String,
        /// Its new value, SI units
        #[arg(value_parser = finite, allow_hyphen_values = true)]
        value: f64,
        /// Which daemon
        #[command(flatten)]
        bus: BusArgument,
    },
}

/// Default lift of a grasp, mm (ours: clear of the table, seen at a glance).
pub const LIFT_MM: f64 = 40.0;
/// Default hold of a grasp, s (ours: ten slip windows).
pub const HOLD_S: f64 = 1.0;

/// A hand, as users name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum HandName {
    /// The left hand
    Left,
    /// The right hand
    Right,
}

impl From<HandName> for Hand {
    fn from(name: HandName) -> Self {
        match name {
            HandName::Left => Self::LEFT,
            HandName::Right => Self::RIGHT,
        }
    }
}

fn finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("needs a finite number, for example 40 or 0.5".into()),
    }
}

fn position_m(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, String> = text.split(',').map(finite).collect();
    numbers
        .ok()
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| {
            "needs three finite numbers in metres, X,Y,Z, for example 0.32,-0.15,0.035".into()
        })
}

fn duration(text: &str) -> Result<Duration, String> {
    finite(text)
        .ok()
        .and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
        .filter(|duration| !duration.is_zero())
        .ok_or_else(|| "needs a number of seconds above zero, for example 30".into())
}

fn bytes(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let (digits, shift) = match text.char_indices().last() {
        Some((at, 'k' | 'K')) => (&text[..at], 10),
        Some((at, 'M')) => (&text[..at], 20),
        Some((at, 'G')) => (&text[..at], 30),
        _ => (text, 0),
    };
    let number = digits.parse::<u64>().ok().filter(|number| *number > 0);
    number
        .and_then(|number| number.checked_mul(1 << shift))
        .ok_or_else(|| "needs a whole number of bytes, or of K, M or G, for example 500M".into())
}
