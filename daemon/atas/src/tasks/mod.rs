//! Tasks: which modules work in which step, as data. A task is a list of [`Step`]s; a step is a list of modules, a
//! motion and an end condition. Nothing here looks at forces: that is what the modules are for.

mod grasp;
mod runner;
mod sites;
mod thresholds;

pub use grasp::{BACK_OUT, GRASP, RELEASE};
pub use runner::{Outcome, Runner};
pub use sites::{Site, Sites};
pub use thresholds::Thresholds;

use crate::modules::Selection;

/// One step of a task.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Name, as users see it.
    pub name: &'static str,
    /// How the hand moves.
    pub motion: Motion,
    /// Which modules work.
    pub modules: Selection,
    /// When the step is done.
    pub until: Until,
    /// When it has taken too long, s.
    pub timeout_s: f64,
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
    /// Stays and opens.
    Open,
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
}
