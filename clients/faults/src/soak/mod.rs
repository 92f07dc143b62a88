//! Soak: random tasks with random events in virtual time, judged at every tick.
//!
//! ```text
//!  seed ─▶ Episode: robot, task, object, poses, events ─▶ OfflineRun ─▶ judge ─▶ violation
//!                                                            └─ shrink ─▶ command that repeats it
//! ```
//!
//! * **In:** number of ticks, seed, robots, settings. **Out:** a [`SoakReport`].
//! * **Invariants:** an episode depends on seed, number and robots only, not on threads or other
//!   episodes. A shrunk failure breaks the same rule with fewer events and ticks.
//! * **Not included:** processes and the bus; `atas fault run` covers them.

mod episode;
mod event;
mod plan;
mod play;
mod shrink;

pub use plan::{SoakFailure, SoakPlan, SoakReport};
