//! What follows from the runs of an experiment, in files: `findings.json`, `summary.json`, `runs.csv`, `curves.csv`, the best
//! table of every team size, and on demand one row per trial.
//!
//! **In**: a plan, its finished runs, what the analysis found in them. **Out**: files that can be made again at any time.

mod files;
mod summary;

pub use files::{write_results, write_trials};
pub use summary::{ConditionSummary, OrderSummary, Summary, write_summary};
