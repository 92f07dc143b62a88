//! Controller of the agents of a field that another process hosts on the bus.
//!
//! ```text
//!  table files ─▶ Lookup ── Exchange ────┐ (between two frames)
//!                                        ▼
//!            AgentSensors ─────▶ TeamController ─────▶ WheelCommands {output bits, table hash}
//! ```
//!
//! Input: the sensor rows of all robots in a frame. Output: the wheel commands of all robots, once
//! per frame, immediately.
//!
//! Invariants:
//!
//! * Tables drive only the field that they were evolved for, unless any field is allowed.
//! * All robots of a frame use the same set of tables.
//! * Invalid tables never replace those in use: the new [`Lookup`] is complete before it is
//!   offered.
//! * Answering does not block or lock. It allocates once, inside the transport.
//! * If this process ends, the field process stops the robots.
//!
//! Not part of this module: the field, its clock, and memory between frames (paper III.a: a
//! behaviour table maps sensors to motors).

mod controller;
mod exchange;
mod lookup;

pub use controller::{Counts, FieldPolicy, TeamController};
pub use exchange::Exchange;
pub use lookup::{Lookup, field_hash};
