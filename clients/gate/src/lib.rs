//! Gate: lets members of group `atas` observe, stop and command a robot on the bus of another user.
//!
//! Shared memory has no group permissions: every process that can attach to a bus can write to it.
//! So only the owner of the bus attaches. If the bus of a command belongs to another user, the
//! command passes its arguments, a few environment variables and its three standard streams to the
//! gate. The gate runs the same command as the bus's user on those streams, if the configuration
//! permits it.
//!
//! ```text
//!  atas (member) ── Request, 3 descriptors ─▶ atas-gate ─▶ atas-gate --visit ─▶ atas (user atas)
//!       ── a byte per signal ──────────────────────────────▶ │ decides, relays        │
//!       ◀── Reply: started … ended ──────────────────────────┘                        │
//!  member's terminal ◀────────────────────────────────────────────────────────────────┘
//! ```
//!
//! * **Input:** a command that this user cannot run. **Output:** its exit code, or an error with
//!   the missing permission.
//! * **Invariants**
//! * The kernel controls access: the socket belongs to the group, and `SO_PEERCRED` identifies the
//!   client.
//! * The definition of the command line decides which commands pass
//!   ([`atas_console::arguments::Access`]), not their spelling. Unknown commands are rejected.
//! * The client supplies only words, and streams that it had opened: no path, folder, program,
//!   library, limit or controlling terminal.
//! * A stop passes for every member, even beyond the user's connection limit and with an unreadable
//!   configuration.
//! * If the client or the gate dies, its command is killed.
//! * Each connection has a separate process on both sides. A process that hangs uses only one slot
//!   of its user.
//! * **Not included:** permissions of single users (groups serve this purpose); suspending a
//!   command (Ctrl-Z), because a suspended process could hold a lock of the bus.

mod client;
mod isolation;
pub mod message;
mod missing;

pub use client::run_through_gate;
pub use isolation::isolate;
pub use missing::missing;
