//! The grasp (paper II.b (1), Fig. 4): modules 1, 2 and 3.

use super::{Motion, Site, Step, Task, Track, Until};
use crate::modules::Selection;
use shm_schemas::ModuleId;

pub(super) const CARRY: Selection = Selection::of(&[ModuleId::CARRY]);
/// Moves freely, and expects to touch nothing.
const FREE: Selection = CARRY.and(Selection::of(&[ModuleId::GUARD]));
pub(super) const TOUCH: Selection = Selection::of(&[ModuleId::FIRST_TOUCH]);
pub(super) const PROBE: Selection = Selection::of(&[ModuleId::PROBE]);
pub(super) const GRIP: Selection = Selection::of(&[
    ModuleId::FIRST_TOUCH,
    ModuleId::PROBE,
    ModuleId::FORCE_LIMIT,
]);
const LOWER: Selection = Selection::of(&[ModuleId::CARRY, ModuleId::FORCE_LIMIT]);
/// The modules that hold an object: modules 1, 2, 3, and the probe, which goes on listening.
pub(super) const SECURE: Selection = Selection::of(&[
    ModuleId::FIRST_TOUCH,
    ModuleId::PROBE,
    ModuleId::SLIP,
    ModuleId::FORCE_LIMIT,
]);
/// The same, with no more force than needed.
const HOLD: Selection = SECURE.and(Selection::of(&[ModuleId::RELAX]));
const LIFT: Selection = HOLD.and(Selection::of(&[ModuleId::CARRY, ModuleId::LIFT_PROOF]));

pub(super) const REACH: Step = Step::new(
    "reach",
    Motion::Reach(Site::BeforeSource),
    FREE,
    Until::Arrived,
    20.0,
);
pub(super) const DESCEND: Step = Step::new(
    "descend",
    Motion::Reach(Site::Source),
    FREE,
    Until::Arrived,
    10.0,
);
pub(super) const APPROACH: Step =
    Step::new("approach", Motion::Stay, TOUCH, Until::AllTouched, 20.0);
pub(super) const FEEL: Step = Step::new("probe", Motion::Stay, PROBE, Until::HardnessKnown, 3.0);
pub(super) const GRASP_IT: Step = Step::new("grip", Motion::Stay, GRIP, Until::Gripped, 5.0);
const LIFT_IT: Step = Step::new(
    "lift",
    Motion::Carry(Site::Lifted),
    LIFT,
    Until::Arrived,
    120.0,
);
pub(super) const OPEN: Step = Step::new("open", Motion::Open, CARRY, Until::Arrived, 10.0);
pub(super) const LEAVE: Step = Step::new(
    "leave",
    Motion::Reach(Site::Above),
    CARRY,
    Until::Arrived,
    10.0,
);
pub(super) const GO_HOME: Step = Step::new(
    "home",
    Motion::Reach(Site::Home),
    CARRY,
    Until::Arrived,
    20.0,
);
const HOLD_IT: Step = Step::new("hold", Motion::Stay, HOLD, Until::Held, f64::INFINITY);

/// Grasp, lift and hold. The last step stays in force after the goal is reached: the hand keeps watching what it holds.
pub static GRASP: Task = Task::of(
    "grasp",
    &[REACH, DESCEND, APPROACH, FEEL, GRASP_IT, LIFT_IT, HOLD_IT],
);

/// Keeps holding what the hand has when its goal ends.
pub const STAND: Track = Track::of(&[HOLD_IT]);

/// Backs out of a refused object: down again, open, away.
pub const BACK_OUT: Track = Track::of(&[
    Step::new(
        "lower",
        Motion::Carry(Site::Source),
        LOWER,
        Until::Arrived,
        60.0,
    ),
    OPEN,
    Step::new(
        "leave",
        Motion::Reach(Site::BeforeSource),
        CARRY,
        Until::Arrived,
        10.0,
    ),
]);

/// Goes back the way that the hand came, off what it touched there.
pub const WITHDRAW: Track = Track::of(&[Step::new(
    "withdraw",
    Motion::Withdraw,
    CARRY,
    Until::Arrived,
    20.0,
)]);

/// Opens the hand where it is and brings it home.
pub static RELEASE: Task = Task::of("release", &[OPEN, LEAVE, GO_HOME]);
