//! Offline evaluation: runs seeded trials of a task in process and in virtual time, evaluates them
//! against ground truth, and reports counts and figures.
//!
//! ```text
//!  Plan (task, objects, conditions, baselines, seeds)
//!   └─▶ trial ─ Scene (a member of a family), goal from nominal knowledge, GripPolicy
//!        └─▶ OfflineRun ─ controller and world in turn ─▶ judge: feasibility and outcome
//!             ├─▶ Report: counts, ratios, intervals; markdown: result tables
//!             ├─▶ TrialRow: one row per trial; parts: an evaluation on several machines
//!             └─▶ figures: the same run, tick by tick, as SVG
//!
//!  drawing: robots and scenes as SVG or pixels
//!
//!  a coarse position policy ─▶ reflex: the same targets with and without the reflex modules
//!
//!  a behaviour table and modules in one robot ─▶ hybrid: fetch, carry on wheels, set down
//!
//!  held: one object grasped, lifted and held
//!   ├─▶ sensor_effects: drifting, hysteretic or creeping sensors
//!   ├─▶ disturbances: loads, bumps, lagging servos
//!   └─▶ gentleness: peak force, deformation and slip of reference objects
//!
//!  recordings of real fingertips ─▶ recorded: production perception against labels
//! ```
//!
//! * **In:** a [`Plan`], or a task and a seed. **Out:** a [`Report`], or a figure.
//! * **Invariants:** each trial's seed derives from the object's name and the trial number. Except
//!   for times, the report depends on the plan only, not on threads. Baselines get the same family
//!   members and noise as the ATAS modules.
//! * **Replay:** [`replay`] feeds a recording to the production controller.
//! * **Not included:** terminal and bus. No feasibility of a built-in object is stored; [`judge`]
//!   computes it.

mod condition;
mod disturbances;
pub mod drawing;
mod drawn;
mod execute;
pub mod figures;
mod finding;
mod gentleness;
mod held;
pub mod hybrid;
mod markdown;
mod nominal_trial;
pub mod offline;
mod parallel;
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
mod sensor_effects;
mod sensor_variant;
pub mod shadow_controller;
mod statistics;
mod tally;
mod trial;

pub use atas_tasks::{SIDE, Task, goals, judge};
pub use condition::{
    Condition, NamedErrors, NamedSensorModel, Noise, conditions, error_conditions,
};
pub use disturbances::{DisturbancePlan, DisturbanceReport, DisturbanceRow};
pub use execute::Evaluated;
pub use finding::Finding;
pub use gentleness::{
    GentlenessPlan, GentlenessReport, GentlenessRow, RobustnessRow, reference_objects,
    reference_or_other,
};
pub use held::{HeldPlan, HeldSummary, Outcomes};
pub use markdown::{RobotResults, SkinResults, errors_table, robots_table, skins_table, table};
pub use nominal_trial::NominalTrial;
pub use parallel::run_indexed;
pub use physics::{ByPhysics, Feasible, Infeasible, Physics};
pub use plan::{Plan, Shard};
pub use policy::GripPolicy;
pub use reflex::{CoarsePolicy, ReflexPlan, ReflexReport};
pub use report::{Baseline, Family, Report, Row};
pub use rows::TrialRow;
pub use sensor_effects::{EffectReport, EffectRow, sensor_effects};
pub use sensor_variant::SensorVariant;
pub use sim_backend::random::trial_seed;
pub use statistics::{median, wilson};
pub use tally::Tally;
pub use trial::{Record, VariantTrial};
