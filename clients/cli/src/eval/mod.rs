//! Batch evaluation: many seeded trials in process, in virtual time, on all cores.
//!
//! **In:** a [`Plan`]. **Out:** a [`Report`]. A plan is a task, its objects, the conditions under which it is tried, and
//! baselines to beat. Every trial has a seed of its own, made from the object's name and the trial's number, and results
//! are kept in the order of the plan: everything in the report but the times is a function of the plan, whatever the
//! number of threads. Baselines meet the same members of the families as our modules do, with the same noise.

mod command;
mod finding;
mod law;
mod plan;
mod report;
mod statistics;
mod table;
mod task;
mod trial;

pub(crate) use command::evaluate;
pub use finding::{Finding, Grasped};
pub use law::Law;
pub use plan::{Condition, Noise, Plan};
pub use report::{Baseline, Family, Feasible, Infeasible, Physics, Report, Row, Tally};
pub use statistics::wilson;
pub(crate) use task::SIDE;
pub use task::Task;
pub use trial::{Record, trial_seed};
