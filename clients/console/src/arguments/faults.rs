//! Arguments of `atas fault` and `atas soak`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::evals::TaskName;

/// `atas fault`.
#[derive(Debug, Subcommand)]
pub enum FaultAction {
    /// List the fault catalogue: each fault, the required reaction, and its evidence
    List,
    /// Inject faults into tasks and judge the reaction
    ///
    /// A fault of sensors, joints or time begins at a random moment of each phase of each task, in
    /// virtual time. A fault of processes or of the machine acts on a daemon on a private bus, in
    /// one random phase per task and seed. An independent judge checks every command against all
    /// limits, the promised mode, and the object in the hand. A fault that this machine does not
    /// permit is reported as skipped, with the reason. Exit code 1 if a run fails.
    Run(FaultRun),
}

/// Options for the injection of faults.
#[derive(Args, Clone, Debug)]
pub struct FaultRun {
    /// Numbers or names of faults, for example F01 or frames-lost; F12 has the variants F12a, F12b
    #[arg(value_name = "FAULT", required_unless_present = "all")]
    pub faults: Vec<String>,
    /// All faults of the catalogue
    #[arg(long, conflicts_with = "faults")]
    pub all: bool,
    /// Only this task [default: all that the robot supports]
    #[arg(long)]
    pub task: Option<TaskName>,
    /// Only this phase of the tasks, for example lift [default: each phase]
    #[arg(long = "at", value_name = "PHASE")]
    pub phase: Option<String>,
    /// Seeds per task
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub seeds: u64,
    /// First seed; 1 to 20000 are reserved for tuning
    #[arg(long = "seed", value_name = "N", default_value_t = 20_001, value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub first_seed: u64,
    /// Object of grasp and pick-place: a built-in one or a file
    #[arg(long, value_name = "NAME|FILE", value_parser = super::values::OBJECTS, hide_possible_values = true, default_value = "wood")]
    pub object: String,
    /// Robot: a built-in one (`atas robot list`) or a robot file [default: that of --config, else
    /// two-hand-arm]
    #[arg(long, value_name = "NAME|FILE", value_parser = super::values::ROBOTS, hide_possible_values = true)]
    pub robot: Option<String>,
    /// Configuration of the daemon; its limits give the bounds [default: built-in values]
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Threads; 0 for one per core. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// Options of `atas soak`.
#[derive(Args, Clone, Debug)]
pub struct Soak {
    /// Ticks in total; with --episode, ticks of this episode
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000_000))]
    pub ticks: u64,
    /// Seed: determines every episode
    #[arg(long, value_name = "N", default_value_t = 20_001)]
    pub seed: u64,
    /// Only this episode, for example one that failed
    #[arg(long, value_name = "N")]
    pub episode: Option<u64>,
    /// Only these events of the episode; an empty list for none [default: all]
    #[arg(long, value_name = "N,N", value_delimiter = ',', num_args = 0.., requires = "episode")]
    pub events: Option<Vec<usize>>,
    /// Robot: a built-in one (`atas robot list`) or a robot file [default: that of --config, else
    /// two-hand-arm and arm7-gripper in turn]
    #[arg(long, value_name = "NAME|FILE", value_parser = super::values::ROBOTS, hide_possible_values = true)]
    pub robot: Option<String>,
    /// Configuration of the controller [default: built-in values]
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Threads; 0 for one per core. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}
