//! Assembly (paper II.c, Fig. 8): screws the cap onto the bottle held by the other hand, with all
//! modules.
//!
//! | meeting point | acting hand | helping hand |
//! |---|---|---|
//! | | waits | grasps the bottle from the side |
//! | 1 | picks the cap, places it, screws it, goes home | holds |
//! | 2 | | releases the bottle, goes home |

use super::grasp::{
    APPROACH, CARRY, DESCEND, GO_HOME, GRASP_IT, LEAVE, OPEN, PROBE_IT, REACH, SECURE,
};
use super::name::Name;
use super::pick_place::{CONVEY_IT, LIFT_IT, PLACE_IT};
use super::screw::SCREW_IT;
use super::step::{Motion, Step, Transition, Waypoint};
use super::step_sequence::{StepSequence, Task};
use crate::modules::Selection;
use shm_schemas::ModuleId;

/// Meeting point: the bottle is held.
const BOTTLE_HELD: u8 = 1;
/// Meeting point: the cap is tight and the acting hand is home.
const CAP_CLOSED: u8 = 2;

const REGRIP: Selection = Selection::from_modules(&[ModuleId::FIRST_TOUCH, ModuleId::FORCE_LIMIT]);

const fn reach(name: &str, waypoint: Waypoint) -> Step {
    Step::new(
        name,
        Motion::Reach(waypoint),
        CARRY,
        Transition::Arrived,
        20.0,
    )
}

const fn meet(name: &str, modules: Selection, point: u8) -> Step {
    Step::new(
        name,
        Motion::Stay,
        modules,
        Transition::Met(point),
        f64::INFINITY,
    )
}

/// Screws a cap from its stand onto a bottle.
pub static ASSEMBLE: Task = Task {
    name: Name::new("assemble"),
    acting: StepSequence::from_steps(&[
        meet("wait", Selection::NONE, BOTTLE_HELD),
        REACH,
        DESCEND,
        APPROACH,
        PROBE_IT,
        GRASP_IT,
        LIFT_IT,
        CONVEY_IT,
        PLACE_IT,
        OPEN,
        reach("line up", Waypoint::TurnStart),
        APPROACH,
        Step::new("regrip", Motion::Stay, REGRIP, Transition::Gripped, 5.0),
        SCREW_IT,
        OPEN,
        LEAVE,
        GO_HOME,
        meet("rest", Selection::NONE, CAP_CLOSED),
    ]),
    helping: Some(StepSequence::from_steps(&[
        reach("tilt", Waypoint::Tilted),
        REACH,
        reach("insert", Waypoint::Around),
        DESCEND,
        APPROACH,
        PROBE_IT,
        GRASP_IT,
        meet("hold", SECURE, CAP_CLOSED),
        OPEN,
        reach("back out", Waypoint::BeforeSource),
        GO_HOME,
    ])),
    table: None,
};
