//! Experiments: conditions × seeds, on all cores, resumable, in shards.
//!
//! A folder holds one experiment: `experiment.toml` is the plan, `runs.jsonl` one sealed line per finished run, appended and
//! synced as it finishes, and `under-way/` the checkpoints of runs that are not. The rest is derived from these and can be
//! made again (see [`crate::results`]). What a run comes to depends on the plan and its seed alone, not on threads, order,
//! shards or interruptions.
//!
//! Nothing in a folder is believed: lines carry seals, numbers have ranges, and every genome is evaluated again when it is
//! read. What cannot be evaluated again, when a run's fitness rose, is held by the seal alone.

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
