//! Tasks: which modules work in which step, as data.
//!
//! A [`Task`] has a [`Track`] of [`Step`]s for the acting hand and, for two-handed tasks, one for the helping hand; a
//! step is a motion, a list of modules and an end condition. Nothing here looks at forces: that is what the modules are
//! for. The built-in tasks are tables, each in its file; a user's own have the same shape and keep the same [rules](Rule).
//!
//! | task | modules (paper) | file |
//! |---|---|---|
//! | grasp | 1, 2, 3 | `grasp` |
//! | pick and place | 0', 1, 2, 3, 4 | `pick_place` |
//! | screw | 0, 1, 2, 3, 4 | `screw` |
//! | assembly | all | `assemble` |
//!
//! What goes wrong on the way has tables of its own: [`BACK_OUT`] puts a refused object back, [`WITHDRAW`] turns
//! back from what is in the way, [`RAISE`] lifts again what found no support, [`STAND`] keeps holding when a goal ends.

mod assemble;
mod demands;
mod grasp;
mod name;
mod pick_place;
mod plan;
mod rules;
mod runner;
mod screw;
mod sites;
mod thresholds;
mod track;
mod words;

pub use assemble::ASSEMBLE;
pub use demands::Demands;
pub use grasp::{BACK_OUT, GRASP, RELEASE, STAND, WITHDRAW};
pub use name::Name;
pub use pick_place::{PICK_PLACE, RAISE};
pub(crate) use plan::plan;
pub use rules::{Fault, Part, Rule, TIMEOUT_MAX_S, checked_name};
pub use runner::{HandMotion, Outcome, Runner};
pub use screw::SCREW;
pub use sites::{Site, Sites, from_the_side, home};
pub use thresholds::Thresholds;
pub use track::{STEPS_MAX, Task, Track};
pub use words::{ENDS, MOTIONS, SITES};

use crate::modules::Selection;
use shm_schemas::GoalKind;

/// The built-in tasks.
pub static BUILT_IN: [&Task; 5] = [&GRASP, &PICK_PLACE, &SCREW, &ASSEMBLE, &RELEASE];

/// The built-in task of a kind of goal; `None` for a user's own and for an unknown kind.
#[must_use]
pub fn of(kind: GoalKind) -> Option<&'static Task> {
    match kind {
        GoalKind::GRASP => Some(&GRASP),
        GoalKind::PICK_PLACE => Some(&PICK_PLACE),
        GoalKind::SCREW => Some(&SCREW),
        GoalKind::ASSEMBLE => Some(&ASSEMBLE),
        GoalKind::RELEASE => Some(&RELEASE),
        _ => None,
    }
}

/// One step of a task.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Name, as users see it.
    pub name: Name,
    /// How the hand moves.
    pub motion: Motion,
    /// Which modules work.
    pub modules: Selection,
    /// When the step is done.
    pub until: Until,
    /// When it has taken too long, s.
    pub timeout_s: f64,
}

impl Step {
    /// A step; the arguments in the order of the columns of a task's table.
    #[must_use]
    pub const fn new(
        name: &str,
        motion: Motion,
        modules: Selection,
        until: Until,
        timeout_s: f64,
    ) -> Self {
        Self {
            name: Name::new(name),
            motion,
            modules,
            until,
            timeout_s,
        }
    }
}

/// How the hand moves in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Not at all; the fingers follow the modules.
    Stay,
    /// Freely to a site, fingers opening as the site says.
    Reach(Site),
    /// Gripping to a site, at the lifting speed; the fingers follow the modules.
    Carry(Site),
    /// Gripping to a site, at the conveying speed; the fingers follow the modules.
    Convey(Site),
    /// Gripping straight down, as far as the target may lie below its expected height.
    Lower,
    /// On the square trajectory of Module 0, over and over.
    Square,
    /// Stays and opens.
    Open,
    /// Stays and opens at once, just off what stands.
    LetGo,
    /// Freely back to where the step before began.
    Withdraw,
}

/// When a step is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Until {
    /// The path has ended.
    Arrived,
    /// Every finger has touched.
    AllTouched,
    /// The hardness is known.
    HardnessKnown,
    /// The weakest finger presses more than F_1, or the strongest more than F_2.
    Gripped,
    /// The goal's holding time has passed.
    Held,
    /// A module says so: Module 4.
    Concluded,
    /// Both hands have come to this meeting point; points count up along a track.
    Met(u8),
}
