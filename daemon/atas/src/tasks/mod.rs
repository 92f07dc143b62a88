//! Tasks as data: motion, modules and transition of each step.
//!
//! A [`Task`] has one [`StepSequence`] of [`Step`]s per participating hand, run by the
//! [task executor](crate::executor). User-defined tasks follow the same [rules](Rule) as built-in
//! ones.
//!
//! | task | modules (paper) | file |
//! |---|---|---|
//! | grasp | 1, 2, 3 | `grasp` |
//! | fetch (not in the paper) | 1, 2, 3, no grip relaxation | `fetch` |
//! | pick and place | 0', 1, 2, 3, 4 | `pick_place` |
//! | set-down | as pick and place, object in hand | `pick_place` |
//! | screw | 0, 1, 2, 3, 4 | `screw` |
//! | assembly | all | `assemble` |
//! | teleop (not in the paper) | 1, 2, 3, client's target stream | `teleop` |
//!
//! To add a built-in task, add a file here and a line in `built_in`; `atas task NAME` runs it.
//! `CONTRIBUTING.md` explains new [goal kinds](shm_schemas::GoalKind) and commands.
//!
//! Internal sequences: [`PUT_BACK`], [`WITHDRAW`], [`REGRASP`], [`RAISE`], [`HOLD_AFTER_GOAL`] and
//! [`HOLD_FOUND`].

mod assemble;
mod built_in;
mod fetch;
mod grasp;
mod name;
mod names;
mod pick_place;
mod requirements;
mod rules;
mod screw;
mod step;
mod step_sequence;
mod table;
mod teleop;

pub use assemble::ASSEMBLE;
pub use built_in::{BUILT_IN, by_name, for_kind};
pub use fetch::FETCH;
pub use grasp::{GRASP, HOLD_AFTER_GOAL, HOLD_FOUND, PUT_BACK, REGRASP, RELEASE, SECURE, WITHDRAW};
pub use name::Name;
pub use names::{MOTIONS, TRANSITIONS, WAYPOINTS};
pub use pick_place::{PICK_PLACE, RAISE, SET_DOWN};
pub use requirements::TaskRequirements;
pub use rules::{Part, Rule, RuleViolation, TIMEOUT_MAX_S, validated_step_name};
pub use screw::SCREW;
pub use step::{Motion, Step, Transition, Waypoint};
pub use step_sequence::{STEPS_MAX, StepSequence, Task};
pub use table::{Action, BehaviourTable, CLOSING_MAX_M_S, TableError};
pub use teleop::{HOLD_AFTER_TELEOP, TELEOP, TELEOP_BOTH};
