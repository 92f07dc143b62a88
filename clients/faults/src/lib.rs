//! Fault catalogue: faults, the reactions that they require, and the evidence of each.
//!
//! ```text
//!  catalogue ─▶ FaultPlan ─▶ task without fault ─▶ copy at a random tick of each phase
//!                             └─▶ injection ─▶ OfflineRun ─▶ judge ─▶ Verdict ─▶ FaultReport
//! ```
//!
//! * **In:** faults, tasks, a robot, settings and seeds. **Out:** a [`FaultReport`]: per fault the
//!   runs, the slowest reaction and every run that failed, with the command that repeats it.
//! * **Invariants:** verdicts depend on the plan only, not on threads. The judge shares no code
//!   with the controller.
//! * **Not included:** faults of processes and of the machine. Tests with real processes show
//!   them; the catalogue names each test.

#![forbid(unsafe_code)]

mod catalogue;
mod course;
mod injection;
mod plan;
mod report;
mod verdict;

pub use catalogue::{CATALOGUE, Evidence, Fault, Reaction, find};
pub use course::joint_bounds;
pub use injection::Injection;
pub use plan::FaultPlan;
pub use report::{FaultReport, FaultRow};
pub use verdict::Verdict;
