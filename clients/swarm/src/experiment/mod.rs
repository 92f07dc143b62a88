//! Experiments: conditions × seeds, on all cores, resumable, in shards.
//!
//! A folder holds one experiment: `experiment.toml` is the plan, `runs.jsonl` has one hashed line
//! per finished run (synced to disk), and `under-way/` has the checkpoints of unfinished runs. All
//! other files are derived from these (see [`crate::results`]). The result of a run depends only on
//! the plan and its seed, not on threads, order, shards or interruptions.
//!
//! Reading verifies a folder: line hashes, number ranges, and the points of every genome. The
//! generations in which the fitness rose cannot be recomputed; only the hash protects them.

mod execute;
mod merge;
mod missing;
mod plan;
mod seal;
mod store;
mod verify;

pub use execute::{Progress, execute};
pub use merge::{Merged, merge};
pub use missing::Missing;
pub use plan::{Plan, Shard};
pub use store::{Store, read_folder};
