//! Arguments of `atas assure`.

use std::path::PathBuf;

use clap::Args;

/// `atas assure`.
#[derive(Args, Clone, Debug)]
pub struct Assure {
    /// Claims whose evidence --run collects, by number or name [default: all]
    #[arg(value_name = "CLAIM", requires = "run")]
    pub claims: Vec<String>,
    /// Run the commands of the evidence and store their results
    #[arg(long, conflicts_with = "check")]
    pub run: bool,
    /// Only evidence that is missing, failed or stale
    #[arg(long, requires = "run")]
    pub missing: bool,
    /// Store results that `atas fault run`, `atas soak` or `atas bench stop` of this version
    /// printed on this machine with `--format json`
    #[arg(long, value_name = "FILE", conflicts_with = "check")]
    pub add: Vec<PathBuf>,
    /// Fail if a claim has no passed evidence, or if the page of the guide differs
    #[arg(long)]
    pub check: bool,
    /// Factor for the seeds, ticks and stops of the case
    #[arg(long, value_name = "N", default_value_t = 1, requires = "run", value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub scale: u64,
    /// Write the page, Markdown
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Source tree of this version, with the tests
    #[arg(long, value_name = "FOLDER", default_value = ".")]
    pub source: PathBuf,
    /// Folder of the results [default: clients/assurance/results in the source tree]
    #[arg(long, value_name = "FOLDER")]
    pub results: Option<PathBuf>,
}
