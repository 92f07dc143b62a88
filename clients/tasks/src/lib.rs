//! Tasks of the paper as experiments: the usual scene, a client's goal, and the evaluation of the
//! outcome.
//!
//! ```text
//!  Task ─┬─ scene ─▶ simulator
//!        ├─ goal ──▶ controller, as a client with nominal knowledge requests it
//!        └─ judge ◀─ goal update, ground truth ─▶ success or failure key
//! ```
//!
//! * **In:** a robot, an object; later the ground truth. **Out:** scene, goal, outcome.
//! * **Invariants:** no feasibility of a built-in object is stored; [`judge::Load`] computes it
//!   from the object's physics.
//! * **Not included:** running a goal. `atas-demo` runs it over the bus, `atas-evaluation` in
//!   process.

pub mod goals;
pub mod judge;
mod task;

pub use task::{SIDE, Task};
