//! Stop: a way of its own, that nothing else can occupy.
//!
//! ```text
//!  request ── datagram ─▶ <bus folder>/stop ─▶ Listener (a thread that does nothing else) ─▶ Signal ─▶ the tick
//!     ◀────────────────────── answer ─────────────┘                          ◀── taken ────────────────┘
//! ```
//!
//! * **In:** one datagram from a process of the bus's user, or of root. **Out:** a [`Signal`] that the tick reads without
//!   waiting, and an answer that says whether a tick took it.
//! * **Invariants**
//!   * No shared memory, no start-up lock, no places, no cleaning up: a stop gets through when the bus is full, locked by
//!     a stopped process, or out of memory (`tests/stop.rs`).
//!   * It needs no descriptor, and no room on a disk, at the daemon. A client that can have neither is still heard; only
//!     the answer may not reach it.
//!   * Whatever arrives means stop, whatever it says: who floods the socket stops the robot, and denies nothing. Other
//!     users cannot reach it: the folder and the socket are private, and the kernel tells who sends.
//! * **Absent on purpose:** everything but stopping. To go on, ask on the control service.

mod listener;
mod request;
mod signal;

pub use listener::{Heard, Listener};
pub use request::request;
pub use signal::Signal;

/// Name of the socket in the bus's folder.
pub(crate) const STOP_SOCKET: &str = "stop";
