//! Fetching (ours): the grasp of a robot that drives off with what it has.
//!
//! It lifts as for conveying, and holds by modules that give no force back: what a drive will ask for is not felt before it.

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

/// Grasp, lift and hold fast. As with the grasp, the last step stays in force after the goal is reached.
pub static FETCH: Task = Task::of(
    "fetch",
    &[REACH, DESCEND, APPROACH, FEEL, GRASP_IT, LIFT_IT, HOLD_FAST],
);
