//! What `atas record` may be told.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::BusArgument;
use super::values::{bytes, mcap, note};

/// `atas record`.
#[derive(Args, Clone, Debug)]
pub struct Record {
    /// File to make; it must not exist [default: atas-SECONDS.mcap, seconds since 1970]
    #[arg(long, value_name = "FILE.mcap", value_parser = mcap)]
    pub out: Option<PathBuf>,
    /// Go on in another file (FILE-001.mcap, …) when this one is larger, for example 500M; each can be replayed by itself
    #[arg(long, value_name = "SIZE", value_parser = bytes)]
    pub max_size: Option<u64>,
    /// Keep this many files and remove the oldest
    #[arg(long, value_name = "N", requires = "max_size", value_parser = clap::value_parser!(u16).range(1..))]
    pub max_files: Option<u16>,
    /// End when all files together are larger, for example 20G
    #[arg(long, value_name = "SIZE", value_parser = bytes)]
    pub disk_budget: Option<u64>,
    /// Keep a note in the files, for what the daemon cannot know: a simulator's seed, a table's hash; may be repeated
    #[arg(long = "note", value_name = "KEY=VALUE", value_parser = note)]
    pub notes: Vec<(String, String)>,
    /// Which daemon
    #[command(flatten)]
    pub bus: BusArgument,
}

/// `atas record check` and `atas record repair`.
#[derive(Debug, Subcommand)]
pub enum RecordAction {
    /// Say whether a recording is whole; exit code 1 if it is not
    Check {
        /// The recording
        file: PathBuf,
    },
    /// Save what can be read of a recording into a new file
    Repair {
        /// The recording; it is left as it is
        file: PathBuf,
        /// File to make; it must not exist [default: NAME-repaired.mcap]
        #[arg(long, value_name = "FILE.mcap", value_parser = mcap)]
        out: Option<PathBuf>,
    },
}
