//! Recordings: MCAP files that replay bit for bit and that the public `mcap` tools and Foxglove
//! open.
//!
//! ```text
//!  bus ─▶ record (reads) ─▶ channel ─▶ Recording (rotates, flushes) ─▶ Writer ─▶ FILE.mcap
//!  FILE.mcap ─▶ Reader ─┬─ check, repair: completeness, saving the readable part
//!                       ├─ diff: first difference between two recordings
//!                       ├─ Frames: tactile frames
//!                       ├─ Rows: one per tick ─┬─ export: MCAP with ROS 2 messages, CSV, Parquet,
//!                       │                      │  data sets of LeRobot
//!                       │                      └─ viewers
//!                       └─ replay
//! ```
//!
//! * **Invariants:** a file never overwrites another. A file holds one run of the daemon or a part
//!   of one. Flushed data survive any end of the recorder; every normal end writes the footer. Lost
//!   parts are counted and named.
//! * **Time:** stamps use sensor time (`CLOCK_MONOTONIC`, or virtual time in lock-step). The
//!   metadata contain the wall clock; exports use it ([`Clock`]). A file that continues a run
//!   begins with the controller state at that point, if a [`Follower`] follows the run.
//! * **Not included:** the controller, which the recording or replaying program supplies; seeds of
//!   a simulator and hashes of tables, which the daemon does not know. `--note seed=7` stores them.

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
pub use export::{
    Choices, Dataset, DatasetChoices, Exported, Kind, MessageType, Messages, Outlet, Subject,
    export, export_dataset,
};
pub use follower::{Follower, state};
pub use frames::{Frames, RecordedFrame};
pub use payloads::Recorded;
pub use reader::{Entry, Reader, is_recording, payload};
pub use recorder::record;
pub use rotation::{Bounds, Tally};
pub use rows::{Row, RowInputs, Rows};
pub use runs::runs;
