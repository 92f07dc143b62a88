//! Arguments of `atas fault`.

use clap::{Args, Subcommand};

use super::evals::TaskName;

/// `atas fault`.
#[derive(Debug, Subcommand)]
pub enum FaultAction {
    /// List the fault catalogue: each fault, the required reaction, and its evidence
    List,
    /// Inject faults into tasks in virtual time and judge the reaction
    ///
    /// Each fault begins at a random moment of each phase of each task. An independent judge checks
    /// every command against all limits, the promised mode, and the object in the hand. Exit code 1
    /// if a run fails.
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
    /// Robot: a built-in one (`atas robot list`) or a robot file
    #[arg(long, value_name = "NAME|FILE", value_parser = super::values::ROBOTS, hide_possible_values = true, default_value = super::values::ROBOT)]
    pub robot: String,
    /// Threads; 0 for one per core. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}
