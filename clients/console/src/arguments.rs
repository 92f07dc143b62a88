//! The command line: what a user may type, and how it is read.
//!
//! Users type millimetres and degrees; everything behind this file is in SI units. Values are only checked for being
//! numbers here: which of them the robot can do is the daemon's to say, so that there is one place that knows.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use shm_bus::BusName;

use crate::exit::Exit;
use crate::output::Format;
use shm_schemas::EventKind;
use values::{event_kind, finite};

mod access;
mod benches;
mod calibrates;
mod dashboards;
mod demos;
mod evals;
mod examples;
mod exports;
mod follows;
mod goals;
mod plots;
mod records;
mod robots;
mod topics;
mod values;

pub use access::{Access, Right};
pub use benches::{Bench, BenchLatency, BenchObservers, BenchStop, EchoBy};
pub use calibrates::{Calibrate, CalibrateFit, CalibrationModel, Guide};
pub use dashboards::{Dashboard, Foxglove};
pub use demos::{
    Demo, DemoAssembly, DemoGrasp, DemoHybrid, DemoPickPlace, DemoScrew, DemoSwarm, Running,
};
pub use evals::{
    CalibrationEvaluation, Eval, Evaluation, HybridEvaluation, Merging, RecordedEvaluation,
    ReflexEvaluation, Summary, TaskName, Tuning, Variants,
};
pub use examples::command;
pub use exports::{Explain, Export, ExportKind};
pub use follows::Follow;
pub use goals::{
    Assemble, Grasp, HandName, Known, PickPlace, Release, Screw, Sending, TurnName, UserTask, Zero,
};
pub use plots::{Drawn, Plot, PlotRecorded};
pub use records::{Record, RecordAction};
pub use robots::RobotAction;
pub use topics::Topic;
pub use values::Place;

/// Artificial tactile affordance system: what fingertips feel induces the next movement
#[derive(Debug, Parser)]
#[command(name = "atas", version, after_help = Exit::TABLE, arg_required_else_help = true)]
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

impl Arguments {
    /// What these words say, the program's name first.
    ///
    /// # Errors
    /// They are no command line.
    pub fn of(words: &[&str]) -> Result<Self, clap::Error> {
        Self::try_parse_from(words)
    }
}

/// The commands of both programs.
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
    /// Draw the goals of recorded runs, or of an offline run: forces, modules, trajectories; SVG, PNG or PDF
    #[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
    Plot {
        /// An offline run instead of recordings: a seeded one in this process
        #[command(subcommand)]
        offline: Option<Plot>,
        /// Which recordings
        #[command(flatten)]
        recorded: Option<PlotRecorded>,
    },
    /// Grasp an object, lift it and hold it; Ctrl-C cancels
    Grasp(Grasp),
    /// Grasp an object, carry it to another place and set it down there; Ctrl-C cancels
    PickPlace(PickPlace),
    /// Turn a cap on its bottle until it is tight; Ctrl-C cancels
    Screw(Screw),
    /// Hold a bottle with one hand; put a cap on it with the other, and screw it tight; Ctrl-C cancels
    #[command(visible_alias = "assembly")]
    Assemble(Assemble),
    /// Run a task of your own, which the daemon's configuration defines; Ctrl-C cancels
    Task(UserTask),
    /// Lead a hand: by keys in a terminal, or along a file of targets; touch decides how hard it holds
    Follow(Follow),
    /// Open a hand where it is and bring it home; Ctrl-C cancels
    Release(Release),
    /// Stop now: the robot keeps its place and its grip until `atas recover`
    #[command(visible_alias = "stop")]
    Estop(BusArgument),
    /// Cancel the active goal, whoever sent it; the hands keep what they hold
    Cancel(BusArgument),
    /// Leave a stop or a hold, if its cause is gone
    Recover(BusArgument),
    /// Take what the fingertips of an empty hand feel as nothing: their new zero
    Zero(Zero),
    /// Show how the daemon and its sensors are
    Status(Status),
    /// Show the running system on one screen: forces, fingertips, modules, ticks, services, faults; q ends it
    Top(BusArgument),
    /// Look at the bus itself: its services, what they say, how often
    Topic {
        /// What to do with them
        #[command(subcommand)]
        action: Topic,
    },
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
    /// Show what a robot is: its joints, its fingertips, what it reaches and what it can do
    Robot {
        /// What to do with it
        #[command(subcommand)]
        action: RobotAction,
    },
    /// Calibrate a fingertip from recorded presses: scale, axes, crosstalk, noise, thresholds, compression
    Calibrate {
        /// Which step of it
        #[command(subcommand)]
        action: Calibrate,
    },
    /// Measure this machine
    Bench {
        /// What
        #[command(subcommand)]
        what: Bench,
    },
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
    /// Tell why a goal ended as it did: its steps, the decisive moments with their forces and limits
    Explain(Explain),
    /// Write a recording as what other programs open: MCAP for Rerun, Foxglove and PlotJuggler, CSV, Parquet
    Export(Export),
    /// Look on in a browser: fingertips, forces, modules, the robot; a running daemon or a recording
    Dashboard(Dashboard),
    /// Serve the live topics and the robot to Foxglove, over its WebSocket protocol
    Foxglove(Foxglove),
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

impl Command {
    /// The program that does it: the operator's own, or one beside it that links what the operator's must not.
    #[must_use]
    pub fn program(&self) -> Program {
        match self {
            Self::Demo { .. }
            | Self::Eval { .. }
            | Self::Plot { .. }
            | Self::Bench { .. }
            | Self::Calibrate { .. }
            | Self::Robot { .. }
            | Self::Record { action: None, .. }
            | Self::Replay { .. }
            | Self::Explain(_) => Program::Lab,
            Self::Dashboard(_) | Self::Foxglove(_) => Program::Live,
            _ => Program::Operator,
        }
    }
}

/// The programs that share this command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Program {
    /// `atas`.
    Operator,
    /// `atas-lab`: needs the simulator or the controller.
    Lab,
    /// `atas-live`: a server.
    Live,
}

/// Which bus.
#[derive(Args, Clone, Debug)]
pub struct BusArgument {
    /// Bus of the daemon
    #[arg(long, env = BusName::ENV, default_value_t, value_name = "NAME")]
    pub bus: BusName,
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
    /// Only events of these kinds, separated by commas: goal, step, mode, touch-on, touch-off, module-on, module-off,
    /// stiffness, warning
    #[arg(long = "kind", value_name = "KIND", value_delimiter = ',', value_parser = event_kind)]
    pub kinds: Vec<EventKind>,
    /// Only events of this hand, and those of none
    #[arg(long, value_enum)]
    pub hand: Option<HandName>,
    /// Only the last goal's, from its beginning
    #[arg(long, conflicts_with_all = ["follow", "count"])]
    pub last_goal: bool,
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
