//! The agents' side of a field that somebody else hosts on the bus.
//!
//! ```text
//!  table files ─▶ Lookup ── Exchange ────┐ (between two frames)
//!                                        ▼
//!            AgentSensors ─────▶ TeamController ─────▶ WheelCommands {output bits, hash of the tables}
//! ```
//!
//! **In**: what every robot senses in a frame. **Out**: what every robot does in it, once per frame, as soon as it is asked.
//!
//! Invariants: a field is answered only by tables that were evolved for its numbers, unless any field is asked for; a frame
//! is answered by one set of tables, whole; tables that cannot be used never replace those in use
//! (the new [`Lookup`] is complete before it is offered); answering neither waits nor locks nor allocates, but for the one
//! allocation inside the transport. A process that is gone answers nothing, and the host then stops the robots.
//!
//! Deliberately absent: the field, its clock, and any memory from one frame to the next (paper III.a: a behaviour table
//! maps sensors to motors).

mod controller;
mod exchange;
mod lookup;

pub use controller::{Counts, Fields, TeamController};
pub use exchange::Exchange;
pub use lookup::{Lookup, field_hash};
