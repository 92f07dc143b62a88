//! Recordings: MCAP files that replay bit for bit, and that the public `mcap` tools and Foxglove open.
//!
//! ```text
//!  bus ─▶ record (reads) ─▶ channel ─▶ Recording (rotates, flushes) ─▶ Writer ─▶ FILE.mcap
//!  FILE.mcap ─▶ Reader ─┬─ check, repair: is it whole, what can be saved
//!                       ├─ diff: the first tick and field in which two recordings differ, and how both ended
//!                       ├─ Frames: what the hands felt
//!                       ├─ Rows: one per tick ─┬─ export: MCAP for ROS 2's viewers, CSV, Parquet
//!                       │                      └─ whoever shows it
//!                       └─ whoever replays it
//! ```
//!
//! * **Invariants:** a file never overwrites another. One file holds one run of the daemon, or a part of one. What was
//!   flushed survives any end of the recorder; every ordinary end writes the footer. Lost parts are counted and named.
//! * **Time** in the files is the sensors' time (`CLOCK_MONOTONIC`, or virtual in lock-step). The wall clock stands in
//!   the metadata; what is exported has it ([`Clock`]).
//!   A file that goes on with a run begins with the state that the controller had then, if a [`Follower`] follows the run.
//! * **Absent on purpose:** the controller: who records or replays brings it along. Seeds of a simulator and hashes of tables, which the daemon does not know; what they led to is
//!   in the inputs. `--note seed=7` keeps them.

mod check;
mod clock;
mod diff;
mod export;
mod follower;
mod frames;
pub mod origin;
mod payloads;
mod reader;
mod recorder;
mod rotation;
mod rows;
mod runs;
mod schema;
mod writer;

pub use check::{Contents, check, repair};
pub use clock::Clock;
pub use diff::{Difference, command_difference, diff};
pub use export::{Choices, Exported, Kind, MessageType, Messages, Outlet, Subject, export};
pub use follower::{Follower, state};
pub use frames::{Felt, Frames};
pub use payloads::Recorded;
pub use reader::{Entry, Reader, is_recording, payload};
pub use recorder::record;
pub use rotation::{Bounds, Tally};
pub use rows::{Row, RowInputs, Rows};
pub use runs::runs;
