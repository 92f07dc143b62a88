//! Arguments of `atas export` and `atas explain`.

use std::path::{Path, PathBuf};

use atas_process::file_name::suffix;
use clap::{Args, ValueEnum};

use super::BusArgument;
use super::goals::HandName;
use super::values::{frequency_hz, picture};

/// `atas export`.
#[derive(Args, Clone, Debug)]
pub struct Export {
    /// Files of one run, in order; LeRobot: of several runs
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Output kind
    #[arg(long = "to", value_enum, value_name = "KIND")]
    pub kind: ExportKind,
    /// Output file with the suffix of --to, or LeRobot's folder; it must not exist
    ///
    /// [default: NAME-ros2.mcap, NAME.csv, NAME.parquet or NAME-lerobot beside the recording]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// MCAP: rate of transforms and point clouds; other messages come every tick
    #[arg(long, value_name = "HZ", default_value_t = 100.0, value_parser = frequency_hz)]
    pub pictures_hz: f64,
    /// CSV, Parquet and LeRobot: add all components of all sensor elements
    #[arg(long)]
    pub elements: bool,
    /// LeRobot: frames per second; divides 1000
    #[arg(long, value_name = "FPS", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub fps: u32,
    /// LeRobot: hand whose goals become episodes
    ///
    /// [default: that of the first goal]
    #[arg(long, value_enum)]
    pub hand: Option<HandName>,
    /// LeRobot: task text of all episodes
    ///
    /// [default: a sentence for the kind of goal]
    #[arg(long, value_name = "TEXT")]
    pub task: Option<String>,
}

impl Export {
    /// Returns the output path.
    ///
    /// # Errors
    /// The suffix of `--out` differs from the kind of `--to`.
    pub fn file(&self) -> Result<PathBuf, String> {
        let Some(out) = &self.out else {
            return Ok(self.kind.default_path(&self.files[0]));
        };
        if self.kind == ExportKind::Lerobot {
            return Ok(out.clone());
        }
        let (message, found) = (self.kind.suffix(), suffix(out));
        if found == message {
            return Ok(out.clone());
        }
        let mut kinds = ExportKind::value_variants().iter();
        let is_meant = |kind: &&ExportKind| !found.is_empty() && kind.suffix() == found;
        let (means, cure) = match kinds.find(is_meant) {
            Some(_) => (found.as_str(), format!("rename it, or use --to {found}")),
            None => ("an unknown file type", "rename it".to_owned()),
        };
        Err(format!(
            "could not export to {}: its suffix means {means}, but --to is {message}; needs a name \
             that ends in .{message}; {cure}",
            out.display()
        ))
    }
}

/// `atas explain`.
#[derive(Args, Clone, Debug)]
pub struct Explain {
    /// Files of one run, in order; or `last` for the last goal of a running daemon
    #[arg(required = true, value_name = "FILE|last")]
    pub files: Vec<PathBuf>,
    /// Goal by number, negative from the end, or the last one of a task by name
    ///
    /// [default: the last goal that is more than a release]
    #[arg(long, value_name = "N|TASK", allow_hyphen_values = true)]
    pub goal: Option<String>,
    /// List the goals with their numbers instead
    #[arg(long, conflicts_with_all = ["goal", "out"])]
    pub list: bool,
    /// Also plot the goal with its decisive moments; the suffix sets the format
    #[arg(long, value_name = "FILE.svg|png|pdf", value_parser = picture)]
    pub out: Option<PathBuf>,
    /// Daemon, for `last`
    #[command(flatten)]
    pub bus: BusArgument,
}

impl Explain {
    /// Word that selects the last goal of a running daemon instead of files.
    pub const LAST: &str = "last";
}

/// File formats that `atas export` writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ExportKind {
    /// ROS 2 messages: joints, link transforms, fingertips, forces, thresholds, modules, events
    Mcap,
    /// One line per tick
    Csv,
    /// One row per tick, typed columns
    Parquet,
    /// Data set of LeRobot (v3.0): a folder with one episode per goal
    Lerobot,
}

impl ExportKind {
    /// Returns the default output path, beside the recording.
    fn default_path(self, recording: &Path) -> PathBuf {
        let stem = recording.file_stem().unwrap_or_default().to_string_lossy();
        // Keeps the output apart from the recording, which is MCAP as well.
        let name = match self {
            Self::Mcap => format!("{stem}-ros2.mcap"),
            Self::Lerobot => format!("{stem}-lerobot"),
            _ => format!("{stem}.{}", self.suffix()),
        };
        recording.with_file_name(name)
    }

    /// Returns the file name suffix; none for a folder.
    fn suffix(self) -> &'static str {
        match self {
            Self::Mcap => "mcap",
            Self::Csv => "csv",
            Self::Parquet => "parquet",
            Self::Lerobot => "",
        }
    }
}
