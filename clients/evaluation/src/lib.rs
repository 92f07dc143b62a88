//! Tasks run offline in virtual time: many seeded trials in process, judged by physical truth, counted and drawn.
//!
//! ```text
//!  Plan (task, objects, conditions, baselines, seeds)
//!   └─▶ trial ─ Scene (a member of a family), goal from nominal knowledge, GripPolicy
//!        └─▶ OfflineRun ─ controller and world in turn ─▶ judge: what physics allows, what became of it
//!             ├─▶ Report: counts, ratios, intervals; markdown: the README's tables
//!             ├─▶ TrialRow: one row per trial; parts: an evaluation on several machines
//!             └─▶ figures: the same run, tick by tick, as SVG
//!
//!  a clumsy policy ─▶ reflex: the same targets with a reflex beneath and without it
//!
//!  a behaviour table and modules in one robot ─▶ hybrid: fetch, carry on wheels, set down
//!
//!  recordings of real fingertips ─▶ recorded: production perception, judged by labels
//! ```
//!
//! * **In:** a [`Plan`], or a task and a seed. **Out:** a [`Report`], or a figure.
//! * **Invariants:** every trial has a seed of its own, made from the object's name and the trial's number, and results are kept
//!   in the order of the plan: everything in the report but the times is a function of the plan, whatever the number of
//!   threads. Baselines meet the same members of the families as our modules do, with the same noise.
//! * **Beside it:** [`replay`], a recording fed to the production controller.
//! * **Absent on purpose:** the terminal and the bus, and any knowledge of which object of the built-in set can be held:
//!   [`judge`] computes it.

mod condition;
mod drawn;
mod execute;
pub mod figures;
mod finding;
pub mod hybrid;
pub mod judge;
mod markdown;
pub mod offline;
pub mod parts;
mod physics;
mod plan;
mod policy;
pub mod recorded;
mod reflex;
pub mod replay;
mod report;
mod rows;
pub mod seeds;
pub mod shadow;
mod state;
mod statistics;
mod tally;
mod task;
mod trial;
mod worn;

pub use condition::{Condition, Named, Noise};
pub use execute::Evaluated;
pub use finding::Finding;
pub use markdown::{RobotTried, SkinTried, errors_table, robots_table, skins_table, table};
pub use physics::{ByPhysics, Feasible, Infeasible, Physics};
pub use plan::{Plan, Shard};
pub use policy::GripPolicy;
pub use reflex::{ReflexPlan, ReflexReport, Script};
pub use report::{Baseline, Family, Report, Row};
pub use rows::TrialRow;
pub use sim_backend::random::trial_seed;
pub use statistics::{median, wilson};
pub use tally::Tally;
pub use task::{SIDE, Task};
pub use trial::{Record, WornTrial};
pub use worn::Worn;
