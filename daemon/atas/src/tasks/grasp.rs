//! The grasp (paper II.b (1), Fig. 4): modules 1, 2 and 3.

use super::{Motion, Site, Step, Until};
use crate::modules::Selection;
use shm_schemas::ModuleId;

const CARRY: Selection = Selection::of(&[ModuleId::CARRY]);
const TOUCH: Selection = Selection::of(&[ModuleId::FIRST_TOUCH]);
const PROBE: Selection = Selection::of(&[ModuleId::PROBE]);
const GRIP: Selection = Selection::of(&[
    ModuleId::FIRST_TOUCH,
    ModuleId::PROBE,
    ModuleId::FORCE_LIMIT,
]);
const LOWER: Selection = Selection::of(&[ModuleId::CARRY, ModuleId::FORCE_LIMIT]);
const HOLD: Selection = Selection::of(&[
    ModuleId::FIRST_TOUCH,
    ModuleId::PROBE,
    ModuleId::SLIP,
    ModuleId::FORCE_LIMIT,
    ModuleId::RELAX,
]);
const LIFT: Selection = Selection::of(&[
    ModuleId::CARRY,
    ModuleId::FIRST_TOUCH,
    ModuleId::PROBE,
    ModuleId::SLIP,
    ModuleId::FORCE_LIMIT,
    ModuleId::RELAX,
]);

const fn step(
    name: &'static str,
    motion: Motion,
    modules: Selection,
    until: Until,
    timeout_s: f64,
) -> Step {
    Step {
        name,
        motion,
        modules,
        until,
        timeout_s,
    }
}

/// Grasp, lift and hold. The last step stays in force after the goal is reached: the hand keeps watching what it holds.
pub const GRASP: &[Step] = &[
    step(
        "reach",
        Motion::Reach(Site::AboveSource),
        CARRY,
        Until::Arrived,
        20.0,
    ),
    step(
        "descend",
        Motion::Reach(Site::Source),
        CARRY,
        Until::Arrived,
        10.0,
    ),
    step("approach", Motion::Stay, TOUCH, Until::AllTouched, 20.0),
    step("probe", Motion::Stay, PROBE, Until::HardnessKnown, 3.0),
    step("grip", Motion::Stay, GRIP, Until::Gripped, 5.0),
    step(
        "lift",
        Motion::Carry(Site::Lifted),
        LIFT,
        Until::Arrived,
        120.0,
    ),
    step("hold", Motion::Stay, HOLD, Until::Held, f64::INFINITY),
];

/// Backs out of a refused object: down again, open, away.
pub const BACK_OUT: &[Step] = &[
    step(
        "lower",
        Motion::Carry(Site::Source),
        LOWER,
        Until::Arrived,
        60.0,
    ),
    step("open", Motion::Open, CARRY, Until::Arrived, 10.0),
    step(
        "leave",
        Motion::Reach(Site::AboveSource),
        CARRY,
        Until::Arrived,
        10.0,
    ),
];

/// Opens the hand where it is and brings it home.
pub const RELEASE: &[Step] = &[
    step("open", Motion::Open, CARRY, Until::Arrived, 10.0),
    step(
        "leave",
        Motion::Reach(Site::Above),
        CARRY,
        Until::Arrived,
        10.0,
    ),
    step(
        "home",
        Motion::Reach(Site::Home),
        CARRY,
        Until::Arrived,
        20.0,
    ),
];
