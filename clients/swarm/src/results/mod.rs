//! Output files of an experiment: `findings.json`, `summary.json`, `runs.csv`, `curves.csv`, the
//! best table of every team size, and on demand one row per trial.
//!
//! Inputs: a plan, its finished runs, and their analysis. The files can be regenerated at any time.

mod files;
mod summary;

pub use files::{write_results, write_trials};
pub use summary::{ConditionSummary, OrderSummary, Summary, write_summary};
