//! Fault catalogue: faults, the reactions that they require, and the evidence of each.
//!
//! ```text
//!  catalogue ─▶ FaultPlan ─▶ task without fault ─▶ phases
//!                ├─▶ copy at a random tick of each phase ─▶ injection ─▶ OfflineRun ─▶ judge
//!                └─▶ daemon process in one phase per seed ─▶ process fault ─▶ judge
//!                     └─▶ Verdict, or skipped: reason ─▶ FaultReport
//! ```
//!
//! * **In:** faults, tasks, a robot, a configuration and seeds. **Out:** a [`FaultReport`]: per
//!   fault the runs, the slowest reaction and every run that failed, with the command that repeats
//!   it.
//! * **Invariants:** verdicts in virtual time depend on the plan only, not on threads. The judge
//!   shares no code with the controller. A fault that the machine does not permit never passes.
//! * **Not included:** faults of the swarm, and faults inside the controller. Tests show them; the
//!   catalogue names each test.

#![forbid(unsafe_code)]

mod catalogue;
mod course;
mod injection;
mod plan;
pub mod process;
mod process_fault;
mod report;
pub mod soak;
mod verdict;

pub use catalogue::{CATALOGUE, Evidence, Fault, Reaction, find};
pub use course::joint_bounds;
pub use injection::Injection;
pub use plan::FaultPlan;
pub use process_fault::ProcessFault;
pub use report::{FaultReport, FaultRow};
pub use verdict::Verdict;
