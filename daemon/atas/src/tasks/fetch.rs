//! Fetch (design choice, not in the paper): grasp for a mobile robot that drives away with the
//! object.
//!
//! No module relaxes the grip, because the drive acceleration is not known in advance.

use super::grasp::{APPROACH, DESCEND, GRASP_IT, PROBE_IT, REACH, SECURE};
use super::pick_place::LIFT_IT;
use super::step::{Motion, Step, Transition};
use super::step_sequence::Task;

const SECURE_HOLD: Step = Step::new(
    "hold",
    Motion::Stay,
    SECURE,
    Transition::Held,
    f64::INFINITY,
);

/// Grasps, lifts and holds. The last step stays active after success.
pub static FETCH: Task = Task::one_handed(
    "fetch",
    &[
        REACH,
        DESCEND,
        APPROACH,
        PROBE_IT,
        GRASP_IT,
        LIFT_IT,
        SECURE_HOLD,
    ],
);
