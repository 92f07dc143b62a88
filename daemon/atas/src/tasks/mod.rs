//! Tasks as data: motion, modules and transition of each step.
//!
//! A [`Task`] has one [`Track`] of [`Step`]s per participating hand, run by the
//! [task executor](crate::runner). User-defined tasks follow the same [rules](Rule) as built-in
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
//! Internal sequences: [`BACK_OUT`], [`WITHDRAW`], [`COME_AGAIN`], [`RAISE`], [`STAND`] and
//! [`KEEP`].

mod assemble;
mod built_in;
mod demands;
mod fetch;
mod follow;
mod grasp;
mod name;
mod pick_place;
mod rules;
mod screw;
mod step;
mod table;
mod track;
mod words;

pub use assemble::ASSEMBLE;
pub use built_in::{BUILT_IN, named, of};
pub use demands::Demands;
pub use fetch::FETCH;
pub use follow::{FOLLOW, FOLLOW_BOTH, STAND_LED};
pub use grasp::{BACK_OUT, COME_AGAIN, GRASP, KEEP, RELEASE, SECURE, STAND, WITHDRAW};
pub use name::Name;
pub use pick_place::{PICK_PLACE, RAISE, SET_DOWN};
pub use rules::{Fault, Part, Rule, TIMEOUT_MAX_S, checked_name};
pub use screw::SCREW;
pub use step::{Motion, Step, Transition, Waypoint};
pub use table::{Action, BehaviourTable, CLOSING_MAX_M_S, TableFault};
pub use track::{STEPS_MAX, Task, Track};
pub use words::{MOTIONS, TRANSITIONS, WAYPOINTS};
