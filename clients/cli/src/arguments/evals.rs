//! What `atas eval` may be told.

use clap::{Args, Subcommand};

use super::values::finite;

/// The tasks of `atas eval`.
#[derive(Debug, Subcommand)]
pub enum Eval {
    /// The grasp, over families of objects: mass, friction and stiffness ±20 %, pose ±2 mm and ±5°
    Grasp(EvalGrasp),
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
