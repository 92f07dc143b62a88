//! Stop requests over a dedicated socket, independent of the shared memory of the bus.
//!
//! ```text
//!  request ── datagram ─▶ <bus folder>/stop ─▶ Listener (dedicated thread) ─▶ Signal ─▶ tick
//!     ◀────────────────────── answer ─────────────┘          ◀── taken, shown ─────────────┘
//! ```
//!
//! **In:** one datagram from a process of the bus's user or of root. **Out:** a [`Signal`] that the
//! tick reads without waiting, and an answer that reports whether a tick took the stop. The socket
//! only stops; clients resume over the control service.
//!
//! Invariants:
//! * The path uses no shared memory, start-up lock, slot or clean-up. A stop arrives even if the
//!   bus is full, locked by a suspended process or out of memory (`tests/stop.rs`).
//! * The daemon needs no new descriptor and no disk space. A client without them can still send,
//!   but may miss the answer.
//! * Every datagram means stop, whatever its content. A process that floods the socket stops the
//!   robot and blocks no other stop.
//! * Other users have no access: folder and socket are private, and the kernel reports the sender.

mod listener;
mod request;
mod signal;

pub use listener::{Listener, ReceivedStop};
pub use request::request;
pub use signal::Signal;

pub(crate) const STOP_SOCKET: &str = "stop";
/// Prefix of the names of client sockets.
pub(crate) const CLIENT_SOCKET: &str = "stop-";
