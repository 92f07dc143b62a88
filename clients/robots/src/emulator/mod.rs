//! Servos that are not there: behind a pseudo-terminal, with the motion of a shaft, current, temperature, and faults.
//!
//! ```text
//! pseudo-terminal ─bytes─▶ family (frames, registers) ─requests─▶ chain ─▶ servo (registers, faults) ─▶ shaft (motion)
//! ```
//!
//! * **In:** what a host writes to the terminal; faults from a test or a person. **Out:** what such servos answer.
//! * **Independent of the drivers:** frames, checksums and register tables are written again here, from the vendors' manuals, and
//!   the vendor's own client checks them (`tests/vendor.py`). Emulator and driver cannot share a mistake.
//! * **Time on the wire:** if it is asked for, an answer comes when its last byte would have come at the line speed.
//! * **Absent on purpose:** baud rates of single servos, registers that no driver of ours touches, bulk and registered writes.

mod chain;
mod dynamixel;
mod family;
mod feetech;
mod servo;
mod shaft;
mod terminal;

pub use chain::{Chain, Planned};
pub use servo::Servo;
