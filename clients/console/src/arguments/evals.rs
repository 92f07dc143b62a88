//! Arguments of `atas eval`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use serde::{Deserialize, Serialize};

use super::demos::COURSE_TABLE;
use super::holds::{Disturbances, Gentleness, SensorEffects};
use super::values::{finite, toml};

/// Tasks of `atas eval`.
#[derive(Debug, Subcommand)]
pub enum Eval {
    /// Grasp over object families: mass, friction and stiffness ±20 %, pose ±2 mm and ±5°
    Grasp(Evaluation),
    /// Pick and place over graspable families; the plate height is wrong by up to 10 mm
    PickPlace(Evaluation),
    /// Cap screwing: radius 12 to 20 mm, varied thread friction, angle and pitch
    Screw(Evaluation),
    /// Two-hand assembly of the same caps on free bottles of varied size
    #[command(visible_alias = "assemble")]
    Assembly(Evaluation),
    /// All tasks under default conditions with baselines (results page), about 50 min on one core
    All(Summary),
    /// Effect of each error on each task, singly and combined; about 50 min on one core
    Errors(Summary),
    /// All other built-in robots in their supported tasks (results page), about 25 min on one core
    Robots(Variants),
    /// Grasp with other fingertips on the two-hand arm (results page), about 5 min on one core
    Skins(Variants),
    /// Tactile reflexes below an imperfect policy, with and without the reflexes
    ///
    /// The policy closes too weakly or too hard and moves with jerks, at 10 Hz and with 50 ms
    /// delay.
    Reflex(ReflexEvaluation),
    /// Grasp with fitted calibrations compared with exact calibrations
    ///
    /// The fingertips have unknown gain, axes, noise and compression. `atas calibrate` fits them
    /// from guided presses.
    Calibration(CalibrationEvaluation),
    /// Hold objects for a minute with a drifting, hysteretic or creeping sensor (results page)
    ///
    /// Each effect with and without joint torques; about 10 min on one core.
    SensorEffects(SensorEffects),
    /// Load held objects, bump the arm, let the servos lag (results page)
    ///
    /// Steps, ramps and impulses of 0.5 to 2 times the weight in several directions, also with the
    /// baselines; about 20 min on one core.
    Disturbances(Disturbances),
    /// Force, deformation and slip of reference objects from egg-like to brick-like (results page)
    ///
    /// Also with a fixed-force, a slip-reactive and a position-controlled gripper, with sensor
    /// noise × 1 to 4 and with wrong expected widths; about 5 min on one core.
    Gentleness(Gentleness),
    /// Fetch an object with a wheeled robot, carry it across a field, set it down at a goal
    ///
    /// A behaviour table drives the base; tactile modules control the hand.
    Hybrid(HybridEvaluation),
    /// Search the best forces of the baselines on the tuning seeds
    Tune(Tuning),
    /// Evaluate the production perception on a labelled recording of real fingertips
    Recording(RecordedEvaluation),
    /// Merge the parts of an evaluation that was run with --shard into one report
    Merge(MergeParts),
}

/// Options for the evaluation of all tasks.
#[derive(Args, Clone, Debug)]
pub struct Summary {
    /// Trials per condition [default: 200; 48 per error]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: Option<u64>,
    /// First seed [default: 20001]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub first_seed: Option<u64>,
    /// Only these tasks, separated by commas
    #[arg(long, value_name = "TASK", value_delimiter = ',')]
    pub tasks: Vec<TaskName>,
    /// Print the table of the results page as Markdown
    #[arg(long)]
    pub markdown: bool,
    /// Write the table and sample trials to this folder, for the test of the results page
    #[arg(long, value_name = "FOLDER")]
    pub golden: Option<PathBuf>,
    /// Omit the baselines
    #[arg(long)]
    pub no_baselines: bool,
    /// Threads; 0 for one per core. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// Options for the evaluation of other robots and fingertips.
#[derive(Args, Clone, Debug)]
pub struct Variants {
    /// Trials per variant
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: u64,
    /// First seed [default: 20001]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub first_seed: Option<u64>,
    /// Print the table of the results page as Markdown
    #[arg(long)]
    pub markdown: bool,
    /// Write the table and sample trials to this folder, for the test of the results page
    #[arg(long, value_name = "FOLDER")]
    pub golden: Option<PathBuf>,
    /// Threads; 0 for one per core. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// Options for the evaluation of the reflexes.
#[derive(Args, Clone, Debug)]
pub struct ReflexEvaluation {
    /// Trials, distributed over the graspable objects; each runs with and without reflexes
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: u64,
    /// First seed of each object; 1 to 20000 are reserved for tuning [default: 20001]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub first_seed: Option<u64>,
    /// Threads; 0 for one per core. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// Options for the evaluation of calibrations.
#[derive(Args, Clone, Debug)]
pub struct CalibrationEvaluation {
    /// Robot: a built-in one (`atas robot list`) or a robot file
    #[arg(long, value_name = "NAME|FILE", value_parser = super::values::ROBOTS, hide_possible_values = true, default_value = super::values::ROBOT)]
    pub robot: String,
    /// Trials, distributed over the built-in objects; each draws its own fingertips
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: u64,
    /// First seed of each object; 1 to 20000 are reserved for tuning [default: 20001]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub first_seed: Option<u64>,
    /// Frame rate of the fingertip sensors in the grasps
    #[arg(long, value_name = "HZ", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rate_hz: u32,
    /// Threads; 0 for one per core. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// Options for the evaluation of wheeled robots.
#[derive(Args, Clone, Debug)]
pub struct HybridEvaluation {
    /// Robots per course, 1 or 2
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub robots: u8,
    /// Trials: one course per seed
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub seeds: u64,
    /// First seed; 1 to 20000 are reserved for tuning [default: 20001]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub first_seed: Option<u64>,
    /// Table file of `ebts evolve course`, or built-in table
    #[arg(long, value_name = "NAME|FILE", default_value = COURSE_TABLE)]
    pub table: String,
    /// Freeze the fingers after the lift, to measure the benefit of the tactile reflexes
    #[arg(long)]
    pub frozen: bool,
    /// Built-in objects or files, separated by commas, used in turn [default: all graspable
    /// built-in objects]
    #[arg(long, value_name = "NAME|FILE", value_parser = super::values::OBJECTS, hide_possible_values = true, value_delimiter = ',')]
    pub objects: Vec<String>,
    /// Threads; 0 for one per core. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// Task on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TaskName {
    /// Grasp
    Grasp,
    /// Pick and place
    PickPlace,
    /// Cap screwing
    Screw,
    /// Two-hand assembly
    Assembly,
}

/// Options for tuning the baselines.
#[derive(Args, Clone, Debug)]
pub struct Tuning {
    /// Task
    pub task: TaskName,
    /// Trials per candidate
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: u64,
    /// First seed, 1 to 20000
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=20_000))]
    pub first_seed: u64,
    /// Threads; 0 for one per core. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// Options for merging parts.
#[derive(Args, Clone, Debug)]
pub struct MergeParts {
    /// Part files, in any order
    #[arg(value_name = "FILE", required = true)]
    pub parts: Vec<PathBuf>,
    /// Write one row per trial to this file; .csv or .jsonl
    #[arg(long, value_name = "FILE")]
    pub rows: Option<PathBuf>,
}

/// Options for the evaluation of a recording.
#[derive(Args, Clone, Debug)]
pub struct RecordedEvaluation {
    /// Table with one row per frame, or a recording of `atas record`
    ///
    /// The columns of a table select the evaluation: ff_e1… slip, f1_x,f1_y,f1_z,pos1_deg…
    /// stiffness, force_N,pos_mm rupture, fx_counts,fy_counts,fz_counts touches. A recording needs
    /// a daemon with --record-stream: fingertips with several elements allow slip, single-element
    /// fingertips touches.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Column with the true labels, in FILE or in a table beside it that numbers the same cases
    #[arg(long, value_name = "COLUMN")]
    pub labels: Option<String>,
    /// Table with the label column [default for a recording: FILE with the suffix .csv]
    ///
    /// For a recording, each row has from_s,to_s: the interval in which the label is true, seconds
    /// since the first tick. Optional columns: hand,finger (without them the label applies to all
    /// fingertips) and object.
    #[arg(long, value_name = "FILE", requires = "labels")]
    pub labels_file: Option<PathBuf>,
    /// Label values for slip or hard, separated by commas [default: from the model]
    #[arg(long, value_name = "VALUE", value_delimiter = ',', requires = "labels")]
    pub positive: Vec<String>,
    /// Label values for stable or soft; all other values are ignored [default: from the model]
    #[arg(long, value_name = "VALUE", value_delimiter = ',', requires = "labels")]
    pub negative: Vec<String>,
    /// Frame rate, if FILE has no time column [default: from the model]
    #[arg(long, value_name = "HZ", value_parser = super::values::rate)]
    pub rate_hz: Option<f64>,
    /// Object column; --cross-validate keeps each object together [default: object, else one per
    /// case]
    #[arg(long, value_name = "COLUMN")]
    pub objects: Option<String>,
    /// Model constants written by --save [default: built-in]
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// First fit the constants to this recording, which needs the same labels
    #[arg(long, value_name = "FILE", requires = "labels")]
    pub train: Option<PathBuf>,
    /// Write the constants in use to a new file
    #[arg(long, value_name = "FILE.toml", value_parser = toml)]
    pub save: Option<PathBuf>,
    /// Evaluate each object with constants fitted to all other objects of FILE
    #[arg(long, conflicts_with = "train", requires = "labels")]
    pub cross_validate: bool,
}

/// Options for the evaluation of one task.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
pub struct Evaluation {
    /// Robot: a built-in one (`atas robot list`) or a robot file
    #[arg(long, value_name = "NAME|FILE", value_parser = super::values::ROBOTS, hide_possible_values = true, default_value = super::values::ROBOT)]
    pub robot: String,
    /// Fingertip layout instead of the robot's: dome-41, dome-1, flat-RxC-P, cylinder-RxC-P-Q
    ///
    /// R rows, C columns, pitch P mm, radius Q mm; dome-1 has one element.
    #[arg(long, value_name = "LAYOUT")]
    pub skin: Option<String>,
    /// Trials, distributed over the objects
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: u64,
    /// Trials per object, instead of --trials
    #[arg(long, value_name = "N", conflicts_with = "trials", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub seeds: Option<u64>,
    /// First seed, selects the family members; 1 to 20000 are reserved for tuning [default: 20001]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub first_seed: Option<u64>,
    /// Scale of the fingertip sensor noise [default: 1 and 2 for the grasp, random 1 to 2 for
    /// others]
    #[arg(long, value_name = "FACTOR", value_parser = finite)]
    pub noise: Option<f64>,
    /// Frame rate of the fingertip sensors [default: 1000, 100 and 30]
    #[arg(long, value_name = "HZ", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rate_hz: Option<u32>,
    /// Errors of robot, skins, objects and commanded values: all, none, each, or names [default:
    /// none]
    ///
    /// Names are separated by commas, optionally with an amount: `crosstalk,position=2,yaw=5`
    /// (`atas-sim errors` lists them). `each` evaluates one row per error and one with all errors.
    #[arg(long, value_name = "NAME[=AMOUNT]")]
    pub errors: Option<String>,
    /// Model of the fingertip sensors: a built-in name (`atas-sim sensors`) or a file [default:
    /// design]
    ///
    /// A model with a rate replaces the default rates by its own.
    #[arg(long, value_name = "NAME|FILE")]
    #[serde(default)]
    pub sensor_model: Option<String>,
    /// Built-in objects or files, separated by commas; caps for screw and assembly [default: all
    /// suitable]
    #[arg(long, value_name = "NAME|FILE", value_parser = super::values::OBJECTS, hide_possible_values = true, value_delimiter = ',')]
    pub objects: Vec<String>,
    /// Physics engine in a process of its own: `mujoco` with its options, or a program
    ///
    /// MuJoCo needs `pip install 'atas[mujoco]'`; ATAS_PYTHON names another interpreter.
    #[arg(long, value_name = "mujoco|PROGRAM [OPTIONS]")]
    #[serde(default)]
    pub engine: Option<String>,
    /// Omit the baselines: a gripper with fixed force, and one that increases force on slip
    #[arg(long)]
    pub no_baselines: bool,
    /// Force of the first baseline, newtons [default: best force on the tuning seeds]
    #[arg(long, value_name = "N", conflicts_with = "no_baselines", value_parser = finite)]
    pub fixed_force: Option<f64>,
    /// Write one row per trial to this file; .csv or .jsonl
    ///
    /// Columns: drawn properties, verdict, slip, turn, forces, times.
    #[arg(long, value_name = "FILE", conflicts_with = "shard")]
    pub rows: Option<PathBuf>,
    /// Run only part I of N and write it to --out
    ///
    /// The same command resumes an interrupted part. `atas eval merge` merges the parts.
    #[arg(long, value_name = "I/N", requires = "out")]
    pub shard: Option<String>,
    /// File for the trials of a part
    #[arg(long, value_name = "FILE", requires = "shard")]
    pub out: Option<PathBuf>,
    /// Threads; 0 for one per core. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}
