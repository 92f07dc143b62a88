//! Experiments: conditions × seeds, on all cores, resumable, in shards.
//!
//! A folder holds one experiment: `experiment.toml` is the plan, `runs.jsonl` one line per finished run, appended and synced
//! as it finishes, and the rest is derived from these two and can be made again: `findings.json`, `runs.csv`, `curves.csv`,
//! tables and figures. What a run comes to depends on the plan and its seed alone, not on threads, order, shards or
//! interruptions.

mod execute;
mod merge;
mod plan;
mod store;
mod summary;

pub use execute::{Progress, execute};
pub use merge::{Merged, merge};
pub use plan::{Job, Plan, Shard};
pub use store::{Store, read_folder};
pub use summary::{ConditionSummary, OrderSummary, Summary, write_results};
