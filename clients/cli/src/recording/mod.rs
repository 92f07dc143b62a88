//! Recordings: MCAP files that replay bit for bit, and that the public `mcap` tools and Foxglove open.
//!
//! ```text
//!  bus ─▶ record (reads) ─▶ channel ─▶ Recording (rotates, flushes) ─▶ Writer ─▶ FILE.mcap
//!  FILE.mcap ─▶ Reader ─┬─ check, repair: is it whole, what can be saved
//!                       ├─ replay: the production controller on the recorded inputs, every command compared
//!                       └─ diff: the first tick and field in which two recordings differ, and how both ended
//! ```
//!
//! * **Invariants:** a file never overwrites another. One file holds one run of the daemon, or a piece of one. What was
//!   flushed survives any end of the recorder; every ordinary end writes the footer. Lost parts are counted and named.
//! * **Time** in the files is the sensors' time (`CLOCK_MONOTONIC`, or virtual in lock-step). The wall clock stands in
//!   the metadata only.
//! * **Absent on purpose:** seeds of a simulator and hashes of tables, which the daemon does not know; what they led to is
//!   in the inputs. `--note seed=7` keeps them.

mod check;
mod diff;
mod reader;
mod record;
mod replay;
mod rotation;
mod words;
mod writer;

pub(crate) use check::{check, repair};
pub(crate) use diff::diff;
pub(crate) use record::record;
pub(crate) use replay::replay;
