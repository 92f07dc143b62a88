//! ROS 2 bridge of a running daemon.
//!
//! ```text
//!  bus ─▶ topics ─────────────▶ publishers        joints, transforms, forces, states, events
//!  bus ◀─ goals ◀── actions ◀─ clients            grippers and tasks
//!  stop socket ◀── stop ◀───── clients            a thread of its own
//!  bus ◀─ control ◀─ services, parameters         recovery, zero, daemon parameters
//!  bus ◀▶ ros2_control ◀▶ a robot of ros2_control  with --drive
//! ```
//!
//! * **Input:** the bus of a daemon, requests of ROS 2 nodes. **Output:** ROS 2 messages, goals.
//! * **Invariants:** the bridge takes no part in the 1 kHz loop. It works with a missing, ended or
//!   restarted daemon. A stop depends on no other thread. A request with a value that is not
//!   finite, or with too long a text or list, is refused with its cause.
//! * **Not included:** control loops through ROS 2, cameras, planning.

pub mod arguments;
mod clock;
mod goals;
mod link;
mod middleware;
mod parameters;
mod requests;
mod robot;
mod ros2_control;
mod run;
mod topics;
pub mod wire;

pub use run::run;
