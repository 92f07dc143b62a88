//! Arguments of `atas record`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::BusArgument;
use super::values::{bytes, mcap, note};

/// `atas record`.
#[derive(Args, Clone, Debug)]
pub struct Record {
    /// Output file; it must not exist [default: atas-SECONDS.mcap, seconds since 1970]
    #[arg(long, value_name = "FILE.mcap", value_parser = mcap)]
    pub out: Option<PathBuf>,
    /// Start a new file (FILE-001.mcap, …) above this size, for example 500M
    ///
    /// Each file can be replayed on its own.
    #[arg(long, value_name = "SIZE", value_parser = bytes)]
    pub max_size: Option<u64>,
    /// Keep only the newest N files
    #[arg(long, value_name = "N", requires = "max_size", value_parser = clap::value_parser!(u16).range(1..))]
    pub max_files: Option<u16>,
    /// Stop when all files together exceed this size, for example 20G
    #[arg(long, value_name = "SIZE", value_parser = bytes)]
    pub disk_budget: Option<u64>,
    /// Store a note in the files, for example the seed of a simulator; may be repeated
    #[arg(long = "note", value_name = "KEY=VALUE", value_parser = note)]
    pub notes: Vec<(String, String)>,
    /// Daemon to record
    #[command(flatten)]
    pub bus: BusArgument,
}

/// `atas record check` and `atas record repair`.
#[derive(Debug, Subcommand)]
pub enum RecordAction {
    /// Check that a recording is complete; exit code 1 if it is not
    Check {
        /// Recording
        file: PathBuf,
    },
    /// Copy the readable part of a damaged recording into a new file
    Repair {
        /// Damaged recording; it is not changed
        file: PathBuf,
        /// Output file; it must not exist [default: NAME-repaired.mcap]
        #[arg(long, value_name = "FILE.mcap", value_parser = mcap)]
        out: Option<PathBuf>,
    },
}
