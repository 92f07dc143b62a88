//! Tasks: which modules work in which step, as data.
//!
//! A [`Task`] has a [`Track`] of [`Step`]s for the acting hand and, for two-handed tasks, one for the helping hand; a
//! step is a motion, a list of modules and a transition. Nothing here looks at forces or moves anything: the
//! [runner](crate::runner) walks a hand through the steps. The built-in tasks are tables, each in its file; a user's own have the same shape and keep the same [rules](Rule).
//!
//! | task | modules (paper) | file |
//! |---|---|---|
//! | grasp | 1, 2, 3 | `grasp` |
//! | fetch (ours) | 1, 2, 3, and nothing that gives force back | `fetch` |
//! | pick and place | 0', 1, 2, 3, 4 | `pick_place` |
//! | set-down | 0', 1, 2, 3, 4, of what the hand holds | `pick_place` |
//! | screw | 0, 1, 2, 3, 4 | `screw` |
//! | assembly | all | `assemble` |
//! | follow (ours) | 1, 2, 3 beneath a client's stream | `follow` |
//!
//! A new built-in task is a file here and its line in the list in `built_in`: `atas task NAME` runs it. A verb of its own
//! is its [`GoalKind`](shm_schemas::GoalKind) and a line of the command line; `CONTRIBUTING.md` shows one.
//!
//! What goes wrong on the way has tables of its own: [`BACK_OUT`] puts a refused object back, [`WITHDRAW`] turns
//! back from what is in the way, [`COME_AGAIN`] grasps anew where the object was felt to stand, [`RAISE`] lifts again what found no support, [`STAND`] keeps holding when a goal ends, [`KEEP`] what
//! a hand was found gripping.

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
