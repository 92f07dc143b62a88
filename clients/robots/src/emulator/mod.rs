//! Servo emulator: servos behind a pseudo-terminal, with shaft motion, current, temperature, and
//! faults.
//!
//! ```text
//! pseudo-terminal ─bytes─▶ family (frames, registers) ─requests─▶ chain ─▶ servo
//! servo (registers, faults) ─▶ shaft (motion)
//! ```
//!
//! * **Input:** bytes that a host writes to the terminal; faults set by a test. **Output:**
//!   replies.
//! * **Independent of the drivers:** frames, checksums and register tables are implemented
//!   separately from the vendors' manuals and verified by the vendors' clients
//!   (`tests/tests/system/servos/vendor.py`). Emulator and driver therefore share no errors.
//! * **Timing:** optionally, a reply arrives when its last byte would arrive at the line speed.
//! * **Not emulated:** baud rates of single servos, registers that the drivers do not use, bulk and
//!   registered writes.

mod chain;
mod dynamixel;
mod family;
mod feetech;
mod servo;
mod shaft;
mod terminal;

pub use chain::{Chain, PlannedServo, Responder};
pub use servo::Servo;
