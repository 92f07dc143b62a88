//! Arguments of the evaluations that grasp, lift and hold one object.

use clap::Args;

/// Options that these evaluations share.
#[derive(Args, Clone, Debug)]
pub struct HoldOptions {
    /// Trials per object and row
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub seeds: u64,
    /// First seed of each object; 1 to 20000 are reserved for tuning [default: 20001]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub first_seed: Option<u64>,
    /// Physics engine in a process of its own: `mujoco` with its options, or a program
    ///
    /// MuJoCo needs `pip install 'atas[mujoco]'`; ATAS_PYTHON names another interpreter.
    #[arg(long, value_name = "mujoco|PROGRAM [OPTIONS]")]
    pub engine: Option<String>,
    /// Print the table of the results page as Markdown
    #[arg(long)]
    pub markdown: bool,
    /// Threads; 0 for one per core. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// Options for the evaluation of sensor effects.
#[derive(Args, Clone, Debug)]
pub struct SensorEffects {
    /// Built-in objects or files, separated by commas [default: wood, slippery-50, paper-box,
    /// sponge, bottle]
    #[arg(long, value_name = "NAME|FILE", value_parser = super::values::OBJECTS, hide_possible_values = true, value_delimiter = ',')]
    pub objects: Vec<String>,
    /// Shared options.
    #[command(flatten)]
    pub hold: HoldOptions,
}

/// Options for the evaluation of disturbances.
#[derive(Args, Clone, Debug)]
pub struct Disturbances {
    /// Built-in objects or files, separated by commas [default: all that can be held]
    #[arg(long, value_name = "NAME|FILE", value_parser = super::values::OBJECTS, hide_possible_values = true, value_delimiter = ',')]
    pub objects: Vec<String>,
    /// Only cases whose name contains one of these texts, separated by commas, for example bump
    #[arg(long, value_name = "TEXT", value_delimiter = ',')]
    pub cases: Vec<String>,
    /// Omit the baselines: a gripper with fixed force, and one that increases force on slip
    #[arg(long)]
    pub no_baselines: bool,
    /// Shared options.
    #[command(flatten)]
    pub hold: HoldOptions,
}

/// Options for the evaluation of gentleness.
#[derive(Args, Clone, Debug)]
pub struct Gentleness {
    /// Reference objects (paper-cup, foam, strawberry, plastic-cup, tomato, egg, wood, brick),
    /// built-in objects or files, separated by commas [default: all reference objects]
    #[arg(long, value_name = "NAME|FILE", value_delimiter = ',')]
    pub objects: Vec<String>,
    /// Compare all candidates of the baselines on the tuning seeds, best first
    #[arg(long, conflicts_with = "first_seed")]
    pub tune: bool,
    /// Shared options.
    #[command(flatten)]
    pub hold: HoldOptions,
}
