//! What `atas export` and `atas explain` may be told.

use std::path::{Path, PathBuf};

use atas_process::file_name::suffix;
use clap::{Args, ValueEnum};

use super::BusArgument;
use super::values::{frequency_hz, picture};

/// `atas export`.
#[derive(Args, Clone, Debug)]
pub struct Export {
    /// The files of one run, in order
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// What to write
    #[arg(long = "to", value_enum, value_name = "KIND")]
    pub kind: ExportKind,
    /// File to make, whose ending says the same as --to; it must not exist [default: NAME-ros2.mcap, NAME.csv or NAME.parquet,
    /// beside the recording]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// MCAP: transforms and point clouds per second; everything else comes with every tick
    #[arg(long, value_name = "HZ", default_value_t = 100.0, value_parser = frequency_hz)]
    pub pictures_hz: f64,
    /// CSV and Parquet: a column for every component of every element of the fingertips, too
    #[arg(long)]
    pub elements: bool,
}

impl Export {
    /// The file to make. Under a name that ends as something else nothing is written.
    ///
    /// # Errors
    /// What its suffix means, and what `--to` says.
    pub fn file(&self) -> Result<PathBuf, String> {
        let Some(out) = &self.out else {
            return Ok(self.kind.usual_name(&self.files[0]));
        };
        let (said, found) = (self.kind.suffix(), suffix(out));
        if found == said {
            return Ok(out.clone());
        }
        let mut kinds = ExportKind::value_variants().iter();
        let (means, cure) = match kinds.find(|kind| kind.suffix() == found) {
            Some(_) => (found.as_str(), format!("rename it, or say --to {found}")),
            None => ("no kind of file", "rename it".to_owned()),
        };
        Err(format!(
            "could not export to {} because its suffix means {means} and --to says {said}, needs a name that ends in .{said}; {cure}",
            out.display()
        ))
    }
}

/// `atas explain`.
#[derive(Args, Clone, Debug)]
pub struct Explain {
    /// The files of one run, in order; or `last`: the last goal of a running daemon
    #[arg(required = true, value_name = "FILE|last")]
    pub files: Vec<PathBuf>,
    /// Which goal: its number, negative from the end, or a task's name for the last one of it [default: the last that is not a
    /// mere release]
    #[arg(long, value_name = "N|TASK", allow_hyphen_values = true)]
    pub goal: Option<String>,
    /// List the goals instead, with their numbers
    #[arg(long, conflicts_with_all = ["goal", "out"])]
    pub list: bool,
    /// Draw it, too, with the moments that decided; what the picture is, its ending says
    #[arg(long, value_name = "FILE.svg|png|pdf", value_parser = picture)]
    pub out: Option<PathBuf>,
    /// Which daemon, for `last`
    #[command(flatten)]
    pub bus: BusArgument,
}

impl Explain {
    /// What is said instead of a file for the last goal of a running daemon.
    pub const LAST: &str = "last";
}

/// Kinds of files that `atas export` writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ExportKind {
    /// ROS 2 messages: joints, transforms of all links, fingertips, forces, thresholds, modules, events
    Mcap,
    /// One line per tick
    Csv,
    /// One row per tick, typed columns
    Parquet,
}

impl ExportKind {
    /// The usual name of what is written: the recording's, with what it is.
    fn usual_name(self, recording: &Path) -> PathBuf {
        let stem = recording.file_stem().unwrap_or_default().to_string_lossy();
        // The recording itself is MCAP, too.
        let mark = if self == Self::Mcap { "-ros2" } else { "" };
        recording.with_file_name(format!("{stem}{mark}.{}", self.suffix()))
    }

    /// What its files' names end in.
    fn suffix(self) -> &'static str {
        match self {
            Self::Mcap => "mcap",
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        }
    }
}
