//! Pick and place (paper II.b (3), Fig. 7): modules 0', 1, 2, 3 and 4.
//!
//! No module relaxes the grip before the object stands, because conveying leaves no time for it.

use super::grasp::{
    APPROACH, CARRY, DESCEND, GO_HOME, GRASP_IT, LEAVE, OPEN, PROBE_IT, REACH, SECURE,
};
use super::step::{Motion, Step, Transition, Waypoint};
use super::step_sequence::{StepSequence, Task};
use crate::modules::Selection;
use shm_schemas::ModuleId;

const LIFT: Selection = SECURE.union(Selection::from_modules(&[
    ModuleId::CARRY,
    ModuleId::LIFT_VERIFICATION,
]));
const CONVEY: Selection = SECURE.union(Selection::from_modules(&[ModuleId::TRANSFER]));
const PLACE: Selection = CONVEY.union(Selection::from_modules(&[ModuleId::RELEASE_PLACED]));

pub(super) const LIFT_IT: Step = Step::new(
    "lift",
    Motion::Carry(Waypoint::Lifted),
    LIFT,
    Transition::Arrived,
    120.0,
);
pub(super) const CONVEY_IT: Step = Step::new(
    "convey",
    Motion::Convey(Waypoint::OverTarget),
    CONVEY,
    Transition::Arrived,
    60.0,
);
pub(super) const PLACE_IT: Step =
    Step::new("place", Motion::Lower, PLACE, Transition::Concluded, 60.0);

const LET_GO: Step = Step::new("let go", Motion::LetGo, CARRY, Transition::Arrived, 5.0);

/// Grasps at the source, conveys, places at the target and releases.
pub static PICK_PLACE: Task = Task::one_handed(
    "pick-place",
    &[
        REACH, DESCEND, APPROACH, PROBE_IT, GRASP_IT, LIFT_IT, CONVEY_IT, PLACE_IT, LET_GO, OPEN,
        LEAVE, GO_HOME,
    ],
);

/// Places an object that is already in hand and releases it.
pub static SET_DOWN: Task = Task::one_handed(
    "set-down",
    &[CONVEY_IT, PLACE_IT, LET_GO, OPEN, LEAVE, GO_HOME],
);

/// Lifts an object that found no support.
pub const RAISE: StepSequence = StepSequence::from_steps(&[Step::new(
    "raise",
    Motion::Carry(Waypoint::OverTarget),
    LIFT,
    Transition::Arrived,
    60.0,
)]);
