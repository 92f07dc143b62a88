//! The gate: how members of group `atas` look at, stop and command a robot whose bus is another user's.
//!
//! Shared memory knows no rights of groups: whoever may attach to a bus may write on it. So nobody else attaches. A command
//! that finds the bus to be another user's hands its arguments, a few words of its environment and its three standard streams
//! over to the gate, which runs the same command as the bus's user, on those streams, if the configuration lets it.
//!
//! ```text
//!  atas (a member) ── Request, 3 descriptors ─▶ /run/atas-gate.sock ─▶ atas-gate ─▶ atas-gate --visit ─▶ atas (user atas)
//!       ── a byte per signal ───────────────────────────────────────────────────▶      │ decides, relays     │
//!       ◀── Reply: started … ended ────────────────────────────────────────────────────┘                     │
//!  the member's terminal ◀───────────────────────────────────────────────────────────────────────────────────┘
//! ```
//!
//! * **In:** a command that this user cannot run. **Out:** its exit code, or a sentence that says what is missing.
//! * **Invariants**
//!   * Who may knock, the kernel knows: the socket belongs to the group. Who knocked, too (`SO_PEERCRED`).
//!   * A command passes by what it is, not by how it is written: the very definition of the command line reads it
//!     ([`atas_console::arguments::Access`]), and what does not stand there does not pass.
//!   * Nothing of the caller's but words, and streams that the caller had opened: no path, no folder, no program, no library,
//!     no limit, no controlling terminal.
//!   * A stop passes for every member, also beyond a user's places, and while the configuration cannot be read.
//!   * A visitor that dies takes its command along, and so does a gate: as if the command had been killed itself.
//!   * A visitor is a process of its own on both sides. One that hangs holds one of its own user's few places.
//! * **Absent on purpose:** rights of single users (groups are the system's way), stopping and resuming a command (Ctrl-Z): a
//!   stopped process could hold a lock of the bus.

pub mod message;
mod missing;
mod visitor;

pub use missing::missing;
pub use visitor::pass;
