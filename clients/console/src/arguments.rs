//! Command line of the `atas` programs.
//!
//! Users enter millimetres and degrees; all values behind this module are in SI units. The parsers
//! reject values that are not finite numbers or have the wrong unit. The daemon alone checks the
//! limits of the robot.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use shm_bus::BusName;

use crate::exit::Exit;
use crate::output::Format;
use shm_schemas::EventKind;
use values::{event_kind, finite};

mod access;
mod assures;
mod benches;
mod calibrates;
mod dashboards;
mod demos;
mod evals;
mod examples;
mod exports;
mod faults;
mod goals;
mod holds;
mod plots;
mod records;
mod remote;
mod robots;
mod teleop;
mod topics;
mod values;

pub use access::{Access, Right};
pub use assures::Assure;
pub use benches::{Bench, BenchLatency, BenchObservers, BenchRestart, BenchStop, EchoTransport};
pub use calibrates::{Calibrate, CalibrateFit, CalibrateModel, CalibrationModel, Guide};
pub use dashboards::{Dashboard, Foxglove};
pub use demos::{
    Demo, DemoAssembly, DemoGrasp, DemoHybrid, DemoOptions, DemoPickPlace, DemoScrew, DemoSwarm,
};
pub use evals::{
    CalibrationEvaluation, Eval, Evaluation, HybridEvaluation, MergeParts, RecordedEvaluation,
    ReflexEvaluation, Summary, TaskName, Tuning, Variants,
};
pub use examples::command;
pub use exports::{Explain, Export, ExportKind};
pub use faults::{FaultAction, FaultRun, Soak};
pub use goals::{
    Assemble, Grasp, HandName, ObjectProperties, PickPlace, Release, Screw, SendOptions, TurnName,
    UserTask, Zero,
};
pub use holds::{Disturbances, Gentleness, HoldOptions, SensorEffects};
pub use plots::{Plot, PlotOffline, PlotRecorded};
pub use records::{Record, RecordAction};
pub use remote::{Recordings, RemoteAction, RemoteArgument};
pub use robots::RobotAction;
pub use teleop::Teleop;
pub use topics::Topic;
pub use values::Place;

/// Artificial tactile affordance system: robot manipulation controlled by tactile feedback
#[derive(Debug, Parser)]
#[command(name = "atas", version, long_version = shm_bus::long_version(), after_help = Exit::TABLE, arg_required_else_help = true)]
pub struct Arguments {
    /// Format of the results on standard output
    #[arg(
        long,
        value_enum,
        default_value_t,
        global = true,
        value_name = "FORMAT"
    )]
    pub format: Format,
    /// Daemon on another machine
    #[command(flatten)]
    pub remote: RemoteArgument,
    /// Command to run
    #[command(subcommand)]
    pub command: Command,
}

impl Arguments {
    /// Parses a command line; the first word is the program name.
    ///
    /// # Errors
    /// The words are not a valid command line.
    pub fn from_words(words: &[&str]) -> Result<Self, clap::Error> {
        Self::try_parse_from(words)
    }
}

/// The commands of both programs.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a demo task: start daemon and simulator on a private bus, run the task, clean up
    Demo {
        /// Task to run
        #[command(subcommand)]
        task: Demo,
    },
    /// Evaluate a task over many seeded trials in virtual time, without a daemon
    Eval {
        /// Task to evaluate
        #[command(subcommand)]
        task: Eval,
    },
    /// Plot goals of recordings or of an offline run: forces, modules, trajectories; SVG, PNG or
    /// PDF
    #[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
    Plot {
        /// Seeded offline run in this process, instead of recordings
        #[command(subcommand)]
        offline: Option<Plot>,
        /// Recordings to plot
        #[command(flatten)]
        recorded: Option<PlotRecorded>,
    },
    /// Grasp an object, lift it and hold it; Ctrl-C cancels
    Grasp(Grasp),
    /// Grasp an object, carry it to another position and set it down; Ctrl-C cancels
    PickPlace(PickPlace),
    /// Turn a cap on a bottle until it is tight; Ctrl-C cancels
    Screw(Screw),
    /// Hold a bottle with one hand, put a cap on it with the other and screw it tight; Ctrl-C
    /// cancels
    #[command(visible_alias = "assembly")]
    Assemble(Assemble),
    /// Run a task that the daemon's configuration defines; Ctrl-C cancels
    Task(UserTask),
    /// Teleoperate a hand with the keyboard or a file of targets; the daemon controls the grip
    /// force
    Teleop(Teleop),
    /// Open a hand in place and move it home; Ctrl-C cancels
    Release(Release),
    /// Stop the robot: it holds its position and grip until `atas recover`
    #[command(visible_alias = "stop")]
    Estop(BusArgument),
    /// Cancel the active goal of any client; the hands keep their grip
    Cancel(BusArgument),
    /// Leave a stop or hold after its cause is removed
    Recover(BusArgument),
    /// Zero the fingertip sensors of an empty hand at their present reading
    Zero(Zero),
    /// Show the state of the daemon and its sensors
    Status(Status),
    /// Show the running system live: forces, fingertips, modules, ticks, services, faults; q quits
    Top(BusArgument),
    /// Inspect the services of the bus: contents and rates
    Topic {
        /// Action
        #[command(subcommand)]
        action: Topic,
    },
    /// Show events: modules, touches, steps, modes, warnings
    Events(Events),
    /// Read and change daemon parameters
    Param {
        /// Action
        #[command(subcommand)]
        action: Param,
    },
    /// Show the timing of the daemon: wake-up, frame age, tick stages, sensor to command
    Latency(Latency),
    /// Describe a robot: joints, fingertips, workspace, capabilities
    Robot {
        /// Action
        #[command(subcommand)]
        action: RobotAction,
    },
    /// Calibrate a fingertip from recorded presses: scale, axes, crosstalk, noise, thresholds,
    /// compression
    Calibrate {
        /// Calibration step
        #[command(subcommand)]
        action: Calibrate,
    },
    /// Inject faults into tasks and processes and judge the reaction
    Fault {
        /// Action
        #[command(subcommand)]
        action: FaultAction,
    },
    /// Run random tasks with random faults and requests in virtual time, judged at every tick
    ///
    /// An episode has a task, an object and poses of its own, and random events: faults of sensors
    /// and joints, pauses and restarts of the controller, stops, recoveries, cancellations,
    /// parameters, further goals. A violation is shrunk to the fewest events and ticks and printed
    /// as the command that repeats it. Exit code 1 after a violation.
    Soak(Soak),
    /// Show the assurance case: claims about safety, their evidence and its last results
    ///
    /// Reads the results that the source tree stores. `--run` collects them again with `atas fault
    /// run`, `atas soak`, `atas bench stop` and `cargo test`. Exit code 1 if `--check` finds a
    /// claim without passed evidence, evidence that does not exist or is stale, or another page.
    Assure(Assure),
    /// Measure this computer: timing, stop, observers
    Bench {
        /// Measurement
        #[command(subcommand)]
        what: Bench,
    },
    /// Record inputs and outputs of the daemon until Ctrl-C; start before `atasd --record-stream`
    #[command(args_conflicts_with_subcommands = true)]
    Record {
        /// Action on an existing recording
        #[command(subcommand)]
        action: Option<RecordAction>,
        /// Recording options
        #[command(flatten)]
        options: Record,
    },
    /// List and fetch recordings of a folder, or of another machine with --remote
    Recordings {
        /// Action
        #[command(subcommand)]
        action: Recordings,
    },
    /// Replay a recording through the controller and compare every command bit by bit
    ///
    /// Exit code 1 if a command differs.
    Replay {
        /// Files of one run, in order
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
    },
    /// Find the first tick and field in which two recordings differ, and show the final state of
    /// both
    ///
    /// Exit code 1 if they differ.
    Diff {
        /// First recording
        first: PathBuf,
        /// Second recording
        second: PathBuf,
    },
    /// Explain the result of a goal: steps and decisive moments with forces and limits
    Explain(Explain),
    /// Export a recording to MCAP (Rerun, Foxglove, PlotJuggler), CSV, Parquet or LeRobot
    Export(Export),
    /// Show fingertips, forces, modules and robot in a browser, live or from a recording
    Dashboard(Dashboard),
    /// Serve live topics and the robot to Foxglove over WebSocket
    Foxglove(Foxglove),
    /// Check computer, bus and daemon, and recommend fixes; exit code 1 if a check fails
    Doctor(Doctor),
    /// Operate a daemon on another machine: server, keys, check
    Remote {
        /// Action
        #[command(subcommand)]
        action: RemoteAction,
    },
    /// Print the completion script of a shell
    Completions {
        /// Shell
        #[arg(value_enum)]
        shell: clap_complete::Shell,
    },
    /// Write the manual pages
    Man {
        /// Output folder
        folder: PathBuf,
    },
}

impl Command {
    /// Returns the program that executes the command. Only [`Program::Operator`] links neither
    /// controller, simulator nor server.
    #[must_use]
    pub fn program(&self) -> Program {
        match self {
            Self::Demo {
                task: Demo::Swarm(_) | Demo::Hybrid(_),
            }
            | Self::Eval { .. }
            | Self::Fault { .. }
            | Self::Soak(_)
            | Self::Assure(_)
            | Self::Plot { .. }
            | Self::Bench { .. }
            | Self::Calibrate { .. }
            | Self::Robot { .. }
            | Self::Record { .. }
            | Self::Replay { .. }
            | Self::Diff { .. }
            | Self::Explain(_)
            | Self::Export(_) => Program::Lab,
            Self::Demo { .. } => Program::Demo,
            Self::Remote { .. } => Program::Remote,
            Self::Dashboard(_) | Self::Foxglove(_) | Self::Teleop(_) | Self::Top(_) => {
                Program::Live
            }
            _ => Program::Operator,
        }
    }
}

/// Programs that share this command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Program {
    /// `atas`.
    Operator,
    /// `atas-demo`: demos of one robot; links the simulator.
    Demo,
    /// `atas-lab`: links the simulator, the controller and the recordings.
    Lab,
    /// `atas-live`: full-screen terminal, and servers for browser and Foxglove.
    Live,
    /// `atas-remote`: link to daemons on other machines.
    Remote,
}

/// Bus selection.
#[derive(Args, Clone, Debug)]
pub struct BusArgument {
    /// Bus of the daemon
    #[arg(long, env = BusName::ENV, default_value_t, value_name = "NAME")]
    pub bus: BusName,
}

/// `atas doctor`.
#[derive(Args, Clone, Debug)]
pub struct Doctor {
    /// Bus to check
    #[command(flatten)]
    pub bus: BusArgument,
    /// Run the safe fixes first: remove bus files of dead processes, set the frequency governor
    #[arg(long)]
    pub fix: bool,
    /// Print the fixes, but change nothing
    #[arg(long, requires = "fix")]
    pub dry_run: bool,
}

/// `atas status`.
#[derive(Args, Clone, Debug)]
pub struct Status {
    /// Update five times per second until Ctrl-C
    #[arg(long)]
    pub watch: bool,
    /// Daemon to query
    #[command(flatten)]
    pub bus: BusArgument,
}

/// `atas events`.
#[derive(Args, Clone, Debug)]
pub struct Events {
    /// Only these kinds of events, separated by commas: goal, step, mode, touch-on, touch-off,
    /// module-on, module-off, stiffness, warning
    #[arg(long = "kind", value_name = "KIND", value_delimiter = ',', value_parser = event_kind)]
    pub kinds: Vec<EventKind>,
    /// Only events of this hand, and events without a hand
    #[arg(long, value_enum)]
    pub hand: Option<HandName>,
    /// Only events of the last goal, from its beginning
    #[arg(long, conflicts_with_all = ["follow", "count"])]
    pub last_goal: bool,
    /// Continue with new events until Ctrl-C
    #[arg(long)]
    pub follow: bool,
    /// Wait for this many events, then stop
    #[arg(long, value_name = "N")]
    pub count: Option<u64>,
    /// Daemon to query
    #[command(flatten)]
    pub bus: BusArgument,
}

/// `atas latency`.
#[derive(Args, Clone, Debug)]
pub struct Latency {
    /// Update once per second until Ctrl-C
    #[arg(long)]
    pub watch: bool,
    /// Daemon to query
    #[command(flatten)]
    pub bus: BusArgument,
}

/// `atas param`.
#[derive(Debug, Subcommand)]
pub enum Param {
    /// List all parameters with value, range and meaning
    List(BusArgument),
    /// Show one parameter
    Get {
        /// Parameter name, for example `grasp.dr_n`
        name: String,
        /// Daemon to query
        #[command(flatten)]
        bus: BusArgument,
    },
    /// Change one parameter until the daemon restarts
    Set {
        /// Parameter name, for example `grasp.dr_n`
        name: String,
        /// New value, SI units
        #[arg(value_parser = finite, allow_hyphen_values = true)]
        value: f64,
        /// Daemon to change
        #[command(flatten)]
        bus: BusArgument,
    },
}
