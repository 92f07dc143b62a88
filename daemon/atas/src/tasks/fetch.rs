//! Fetch (design choice, not in the paper): grasp for a mobile robot that drives away with the
//! object.
//!
//! No module relaxes the grip, because the drive acceleration is not known in advance.

use super::grasp::{APPROACH, DESCEND, FEEL, GRASP_IT, REACH, SECURE};
use super::pick_place::LIFT_IT;
use super::step::{Motion, Step, Transition};
use super::track::Task;

const HOLD_FAST: Step = Step::new(
    "hold",
    Motion::Stay,
    SECURE,
    Transition::Held,
    f64::INFINITY,
);

/// Grasps, lifts and holds. The last step stays active after success.
pub static FETCH: Task = Task::of(
    "fetch",
    &[REACH, DESCEND, APPROACH, FEEL, GRASP_IT, LIFT_IT, HOLD_FAST],
);
