//! Cap screwing (paper II.b (2), Fig. 5 and 6): modules 0, 1, 2, 3 and 4.

use super::grasp::{APPROACH, DESCEND, GO_HOME, GRASP_IT, LEAVE, OPEN, PROBE_IT, REACH};
use super::step::{Motion, Step, Transition};
use super::step_sequence::Task;
use crate::modules::Selection;
use shm_schemas::ModuleId;

const TURN: Selection = Selection::from_modules(&[
    ModuleId::TRAJECTORY,
    ModuleId::FIRST_TOUCH,
    ModuleId::SLIP,
    ModuleId::FORCE_LIMIT,
    ModuleId::TERMINATE_SCREW,
]);

pub(super) const SCREW_IT: Step =
    Step::new("screw", Motion::Square, TURN, Transition::Concluded, 180.0);

/// Grasps the cap at the start of a turn, turns it repeatedly until tight, releases it.
pub static SCREW: Task = Task::one_handed(
    "screw",
    &[
        REACH, DESCEND, APPROACH, PROBE_IT, GRASP_IT, SCREW_IT, OPEN, LEAVE, GO_HOME,
    ],
);
