//! What `atas export` and `atas explain` may be told.

use std::path::PathBuf;

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
    /// File to make; it must not exist [default: NAME-ros2.mcap, NAME.csv or NAME.parquet, beside the recording]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// MCAP: transforms and point clouds per second; everything else comes with every tick
    #[arg(long, value_name = "HZ", default_value_t = 100.0, value_parser = frequency_hz)]
    pub pictures_hz: f64,
    /// CSV and Parquet: a column for every component of every element of the fingertips, too
    #[arg(long)]
    pub elements: bool,
}

/// `atas explain`.
#[derive(Args, Clone, Debug)]
pub struct Explain {
    /// The files of one run, in order; or `last`: the last goal of a running daemon
    #[arg(required = true, value_name = "FILE|last")]
    pub files: Vec<PathBuf>,
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
    #[must_use]
    pub fn usual_name(self, recording: &std::path::Path) -> PathBuf {
        let stem = recording.file_stem().unwrap_or_default().to_string_lossy();
        recording.with_file_name(match self {
            Self::Mcap => format!("{stem}-ros2.mcap"),
            Self::Csv => format!("{stem}.csv"),
            Self::Parquet => format!("{stem}.parquet"),
        })
    }
}
