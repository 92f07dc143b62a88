//! Assembly (paper II.c, Fig. 8): screws the cap onto the bottle held by the other hand, with all
//! modules.
//!
//! | meeting point | acting hand | helping hand |
//! |---|---|---|
//! | | waits | grasps the bottle from the side |
//! | 1 | picks the cap, places it, screws it, goes home | holds |
//! | 2 | | releases the bottle, goes home |

use super::grasp::{APPROACH, CARRY, DESCEND, FEEL, GO_HOME, GRASP_IT, LEAVE, OPEN, REACH, SECURE};
use super::name::Name;
use super::pick_place::{CONVEY_IT, LIFT_IT, PLACE_IT};
use super::screw::SCREW_IT;
use super::step::{Motion, Step, Transition, Waypoint};
use super::track::{Task, Track};
use crate::modules::Selection;
use shm_schemas::ModuleId;

/// Meeting point: the bottle is held.
const HELD: u8 = 1;
/// Meeting point: the cap is tight and the acting hand is home.
const CLOSED: u8 = 2;

const REGRIP: Selection = Selection::of(&[ModuleId::FIRST_TOUCH, ModuleId::FORCE_LIMIT]);

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
    acting: Track::of(&[
        meet("wait", Selection::NONE, HELD),
        REACH,
        DESCEND,
        APPROACH,
        FEEL,
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
        meet("rest", Selection::NONE, CLOSED),
    ]),
    helping: Some(Track::of(&[
        reach("tilt", Waypoint::Tilted),
        REACH,
        reach("insert", Waypoint::Around),
        DESCEND,
        APPROACH,
        FEEL,
        GRASP_IT,
        meet("hold", SECURE, CLOSED),
        OPEN,
        reach("back out", Waypoint::BeforeSource),
        GO_HOME,
    ])),
    table: None,
};
