//! What `atas eval` may be told.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use serde::{Deserialize, Serialize};

use super::demos::COURSE_TABLE;
use super::values::{finite, toml};

/// The tasks of `atas eval`.
#[derive(Debug, Subcommand)]
pub enum Eval {
    /// The grasp, over families of objects: mass, friction and stiffness ±20 %, pose ±2 mm and ±5°
    Grasp(Evaluation),
    /// Pick and place, over the families that can be held, onto a plate whose height is wrong by up to 10 mm
    PickPlace(Evaluation),
    /// Cap screwing, over caps of 12 to 20 mm radius, and threads of any friction, angle and pitch
    Screw(Evaluation),
    /// Two-hand assembly, over the same caps on free bottles of any size
    #[command(visible_alias = "assemble")]
    Assembly(Evaluation),
    /// Every task under its usual conditions, beside the baselines: the README's table. About 50 minutes of one core
    All(Summary),
    /// What each error costs in every task, one at a time and all at once. About as long
    Errors(Summary),
    /// Every other robot that ships, in what its hand can do: the README's table. About 25 minutes of one core
    Robots(Variants),
    /// The grasp with other fingertips on the two-hand arm: the README's table. About 5 minutes of one core
    Skins(Variants),
    /// A reflex beneath a policy: one that closes too weakly or too hard and moves with jerks, ten times a second and 50 ms late,
    /// with the daemon's touch beneath it and without
    Reflex(ReflexEvaluation),
    /// Grasps with fingertips of unknown gain, axes, noise and compression, calibrated by `atas calibrate` from guided presses on
    /// them, beside the same grasps under the exact calibration
    Calibration(CalibrationEvaluation),
    /// Both methodologies in one robot: fetch an object, carry it over a field on wheels, set it down at a goal. A behaviour table
    /// drives the base, modules move the hand
    Hybrid(HybridEvaluation),
    /// The baselines' forces, tried on the seeds that are for tuning
    Tune(Tuning),
    /// Production perception on a recording of real fingertips, judged by labels
    Recording(RecordedEvaluation),
    /// Put the parts of an evaluation together that were run with --shard: the report of one run
    Merge(Merging),
}

/// How all tasks are evaluated.
#[derive(Args, Clone, Debug)]
pub struct Summary {
    /// Trials under each condition [default: 200; of each error 48]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: Option<u64>,
    /// Number of the first seed [default: 20001]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub first_seed: Option<u64>,
    /// Some of the tasks only, separated by commas
    #[arg(long, value_name = "TASK", value_delimiter = ',')]
    pub tasks: Vec<TaskName>,
    /// Print the table as the README has it
    #[arg(long)]
    pub markdown: bool,
    /// Write the table and some of its trials into this folder, for the test that holds the README to them
    #[arg(long, value_name = "FOLDER")]
    pub golden: Option<PathBuf>,
    /// Leave out the baselines
    #[arg(long)]
    pub no_baselines: bool,
    /// Threads; 0 for one per core. The numbers do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// How other robots and other fingertips are evaluated.
#[derive(Args, Clone, Debug)]
pub struct Variants {
    /// Trials of each
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: u64,
    /// Number of the first seed [default: 20001]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub first_seed: Option<u64>,
    /// Print the table as the README has it
    #[arg(long)]
    pub markdown: bool,
    /// Write the table and some of its trials into this folder, for the test that holds the README to them
    #[arg(long, value_name = "FOLDER")]
    pub golden: Option<PathBuf>,
    /// Threads; 0 for one per core. The numbers do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// How the reflex is evaluated.
#[derive(Args, Clone, Debug)]
pub struct ReflexEvaluation {
    /// Trials, dealt in turn to the objects that can be held; each with the reflex and without
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: u64,
    /// Number of the first seed of each object. 1 to 20000 are for tuning, all others for judging [default: 20001]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub first_seed: Option<u64>,
    /// Threads; 0 for one per core. The numbers do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// How a calibration is evaluated.
#[derive(Args, Clone, Debug)]
pub struct CalibrationEvaluation {
    /// The robot: one that ships (`atas robot list`), or a robot file
    #[arg(long, value_name = "NAME|FILE", default_value = super::values::ROBOT)]
    pub robot: String,
    /// Trials, dealt in turn to the built-in objects; each with fingertips of its own
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: u64,
    /// Number of the first seed of each object. 1 to 20000 are for tuning, all others for judging [default: 20001]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub first_seed: Option<u64>,
    /// Frames per second of the fingertip sensors in the grasps
    #[arg(long, value_name = "HZ", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rate_hz: u32,
    /// Threads; 0 for one per core. The numbers do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// How a robot on wheels is evaluated.
#[derive(Args, Clone, Debug)]
pub struct HybridEvaluation {
    /// Robots on each course, 1 or 2
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub robots: u8,
    /// Trials: courses, each with a seed of its own
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub seeds: u64,
    /// Number of the first seed. 1 to 20000 are for tuning, all others for judging [default: 20001]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub first_seed: Option<u64>,
    /// A table file of `ebts evolve course`, or the table that ships
    #[arg(long, value_name = "NAME|FILE", default_value = COURSE_TABLE)]
    pub table: String,
    /// Freeze the fingers once the object is lifted: what are the reflexes worth on the way?
    #[arg(long)]
    pub frozen: bool,
    /// Built-in objects or files, separated by commas, dealt in turn [default: every built-in one that can be held]
    #[arg(long, value_name = "NAME|FILE", value_delimiter = ',')]
    pub objects: Vec<String>,
    /// Threads; 0 for one per core. The numbers do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// A task by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TaskName {
    /// The grasp
    Grasp,
    /// Pick and place
    PickPlace,
    /// Cap screwing
    Screw,
    /// Two-hand assembly
    Assembly,
}

/// How baselines are tuned.
#[derive(Args, Clone, Debug)]
pub struct Tuning {
    /// Of which task
    pub task: TaskName,
    /// Trials of each candidate
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: u64,
    /// Number of the first seed, one of 1 to 20000
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=20_000))]
    pub first_seed: u64,
    /// Threads; 0 for one per core. The numbers do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// How parts are put together.
#[derive(Args, Clone, Debug)]
pub struct Merging {
    /// The part files, in any order
    #[arg(value_name = "FILE", required = true)]
    pub parts: Vec<PathBuf>,
    /// Write one row per trial into this file; .csv or .jsonl
    #[arg(long, value_name = "FILE")]
    pub rows: Option<PathBuf>,
}

/// How a recording is judged.
#[derive(Args, Clone, Debug)]
pub struct RecordedEvaluation {
    /// A table with one row per frame. Its columns say what can be judged: ff_e1… slip, f1_x,f1_y,f1_z,pos1_deg… hardness,
    /// force_N,pos_mm rupture, fx_counts,fy_counts,fz_counts touches. Or a run that `atas record` wrote of a daemon with
    /// --record-stream: slip on fingertips of several elements, touches on one of a single element
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Column that holds the truth, here or in a table beside FILE that numbers the same cases
    #[arg(long, value_name = "COLUMN")]
    pub labels: Option<String>,
    /// The table that has this column. Of a run: rows of from_s,to_s, the seconds since its first tick between which the label is
    /// true, and perhaps hand,finger (else it is of every fingertip) and object [default for a run: FILE with the ending .csv]
    #[arg(long, value_name = "FILE", requires = "labels")]
    pub labels_file: Option<PathBuf>,
    /// Values of it that mean slip, or hard, separated by commas [default: the model's]
    #[arg(long, value_name = "VALUE", value_delimiter = ',', requires = "labels")]
    pub positive: Vec<String>,
    /// Values of it that mean stable, or soft [default: the model's]; others than these are left out
    #[arg(long, value_name = "VALUE", value_delimiter = ',', requires = "labels")]
    pub negative: Vec<String>,
    /// Frames per second where FILE has no column of time [default: the model's]
    #[arg(long, value_name = "HZ", value_parser = super::values::rate)]
    pub rate_hz: Option<f64>,
    /// Column that tells objects apart, which --cross-validate never splits [default: object, else one per case]
    #[arg(long, value_name = "COLUMN")]
    pub objects: Option<String>,
    /// Constants to judge with, as --save wrote them [default: those that come with the program]
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// Fit the constants to this recording first; it must have the same labels
    #[arg(long, value_name = "FILE", requires = "labels")]
    pub train: Option<PathBuf>,
    /// Write the constants in force to a new file
    #[arg(long, value_name = "FILE.toml", value_parser = toml)]
    pub save: Option<PathBuf>,
    /// Judge each object with constants fitted to all others of FILE
    #[arg(long, conflicts_with = "train", requires = "labels")]
    pub cross_validate: bool,
}

/// How a task is evaluated.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
pub struct Evaluation {
    /// The robot: one that ships (`atas robot list`), or a robot file
    #[arg(long, value_name = "NAME|FILE", default_value = super::values::ROBOT)]
    pub robot: String,
    /// Fingertips of another layout than the robot file's: dome-41, dome-1 (one element), flat-RxC-P (R rows and C columns, P mm
    /// apart), cylinder-RxC-P-Q (bent to a radius of Q mm)
    #[arg(long, value_name = "LAYOUT")]
    pub skin: Option<String>,
    /// Trials, dealt to the objects in turn
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: u64,
    /// Trials of each object, instead
    #[arg(long, value_name = "N", conflicts_with = "trials", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub seeds: Option<u64>,
    /// Number of the first seed: other seeds are other members of the families. 1 to 20000 are for tuning, all others for
    /// judging [default: 20001]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub first_seed: Option<u64>,
    /// Scales the noise of the fingertip sensors [default: 1 and 2 for the grasp, drawn from 1 to 2 for the others]
    #[arg(long, value_name = "FACTOR", value_parser = finite)]
    pub noise: Option<f64>,
    /// Frames per second of the fingertip sensors [default: 1000, 100 and 30]
    #[arg(long, value_name = "HZ", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rate_hz: Option<u32>,
    /// Errors of robot, skins and objects, and of what the controller is told: all, none, or names separated by commas, each
    /// with an amount if it shall not be the usual one, as in `crosstalk,position=2,yaw=5` (`atas-sim errors` lists them); `each`
    /// for a row per error and one for all at once [default: none]
    #[arg(long, value_name = "NAME[=AMOUNT]")]
    pub errors: Option<String>,
    /// Built-in objects or files, separated by commas; for screwing and assembly, caps [default: every built-in one that fits]
    #[arg(long, value_name = "NAME|FILE", value_delimiter = ',')]
    pub objects: Vec<String>,
    /// Leave out the baselines: a gripper of fixed force, and one that grips harder whenever it slips
    #[arg(long)]
    pub no_baselines: bool,
    /// Force of the first baseline, newtons [default: the best for the task on other seeds]
    #[arg(long, value_name = "N", conflicts_with = "no_baselines", value_parser = finite)]
    pub fixed_force: Option<f64>,
    /// Write one row per trial into this file: what was drawn, verdict, slip, turn, forces, times; .csv or .jsonl
    #[arg(long, value_name = "FILE", conflicts_with = "shard")]
    pub rows: Option<PathBuf>,
    /// Run only the I-th of N parts, into the file that --out names; the same command again goes on where it ended. `atas eval
    /// merge` puts the parts together
    #[arg(long, value_name = "I/N", requires = "out")]
    pub shard: Option<String>,
    /// Where a part's trials are kept
    #[arg(long, value_name = "FILE", requires = "shard")]
    pub out: Option<PathBuf>,
    /// Threads; 0 for one per core. The numbers do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}
