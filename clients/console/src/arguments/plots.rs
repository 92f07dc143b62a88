//! What `atas plot` may be told.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::values::picture;

/// `atas plot RECORDING`.
#[derive(Args, Clone, Debug)]
pub struct PlotRecorded {
    /// Recordings, up to seven runs; files that go on with a run belong to it
    #[arg(required = true, value_name = "RECORDING")]
    pub files: Vec<PathBuf>,
    /// Which goal of each run: its number, negative from the end, or a task's name [default: the last that is not a mere release]
    #[arg(long, value_name = "N|TASK", allow_hyphen_values = true)]
    pub goal: Option<String>,
    /// Begin where the goal first enters this step, so that several runs lie over each other [default: where it begins]
    #[arg(long, value_name = "STEP")]
    pub from: Option<String>,
    /// The picture to write; what it is, its ending says
    #[arg(long, value_name = "FILE.svg|png|pdf", value_parser = picture)]
    pub out: PathBuf,
}

/// The offline runs of `atas plot`.
#[derive(Debug, Subcommand)]
pub enum Plot {
    /// Forces between F_1 and F_2, the lift, and which module worked when
    Grasp(Drawn),
    /// The release of placing: support, grip, opening and height around the contact
    PickPlace(Drawn),
    /// The square trajectory and what contact made of it (Fig. 6); the cap's angle and torque
    Screw(Drawn),
    /// What both hands do, their grips, the cap's angle and torque
    #[command(visible_alias = "assemble")]
    Assembly(Drawn),
}

/// What is drawn, and where to.
#[derive(Args, Clone, Debug)]
pub struct Drawn {
    /// A built-in object or a file; for screwing and assembly, a cap [default: wood, or the built-in cap]
    #[arg(long, value_name = "NAME|FILE")]
    pub object: Option<String>,
    /// Which member of its family, as in `atas eval`
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// The picture to write; what it is, its ending says
    #[arg(long, value_name = "FILE.svg|png|pdf", value_parser = picture)]
    pub out: PathBuf,
}
