//! Arguments of `atas plot`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::values::picture;

/// `atas plot RECORDING`.
#[derive(Args, Clone, Debug)]
pub struct PlotRecorded {
    /// Recordings of up to seven runs; continuation files belong to their run
    #[arg(required = true, value_name = "RECORDING")]
    pub files: Vec<PathBuf>,
    /// Goal of each run: its number, negative from the end, or a task name
    ///
    /// [default: the last goal that is more than a release]
    #[arg(long, value_name = "N|TASK", allow_hyphen_values = true)]
    pub goal: Option<String>,
    /// Align the runs at the first entry into this step [default: start of the goal]
    #[arg(long, value_name = "STEP")]
    pub from: Option<String>,
    /// Output file; the suffix sets the format
    #[arg(long, value_name = "FILE.svg|png|pdf", value_parser = picture)]
    pub out: PathBuf,
}

/// Offline runs of `atas plot`.
#[derive(Debug, Subcommand)]
pub enum Plot {
    /// Forces between F_1 and F_2, lift height and active modules
    Grasp(PlotOffline),
    /// Set-down of the object: support, grip, opening and height around contact
    PickPlace(PlotOffline),
    /// Square trajectory with and without contact (Fig. 6); angle and torque of the cap
    Screw(PlotOffline),
    /// Motion and grip of both hands; angle and torque of the cap
    #[command(visible_alias = "assemble")]
    Assembly(PlotOffline),
}

/// Options of an offline plot.
#[derive(Args, Clone, Debug)]
pub struct PlotOffline {
    /// Built-in object or object file; a cap for screw and assembly [default: wood, or the built-in
    /// cap]
    #[arg(long, value_name = "NAME|FILE", value_parser = super::values::OBJECTS, hide_possible_values = true)]
    pub object: Option<String>,
    /// Seed that selects the member of the object family, as in `atas eval`
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Output file; the suffix sets the format
    #[arg(long, value_name = "FILE.svg|png|pdf", value_parser = picture)]
    pub out: PathBuf,
}
