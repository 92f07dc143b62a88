//! Grasp (paper II.b (1), Fig. 4): modules 1, 2 and 3.

use super::step::{Motion, Step, Transition, Waypoint};
use super::step_sequence::{StepSequence, Task};
use crate::modules::Selection;
use shm_schemas::ModuleId;

pub(super) const CARRY: Selection = Selection::from_modules(&[ModuleId::CARRY]);
/// Free motion with contact guard.
const FREE: Selection = CARRY.union(Selection::from_modules(&[ModuleId::CONTACT_GUARD]));
pub(super) const TOUCH: Selection = Selection::from_modules(&[ModuleId::FIRST_TOUCH]);
pub(super) const PROBE: Selection = Selection::from_modules(&[ModuleId::PROBE]);
pub(super) const GRIP: Selection = Selection::from_modules(&[
    ModuleId::FIRST_TOUCH,
    ModuleId::PROBE,
    ModuleId::FORCE_LIMIT,
]);
const LOWER: Selection = Selection::from_modules(&[ModuleId::CARRY, ModuleId::FORCE_LIMIT]);
/// Modules that hold an object: 1, 2, 3 and the probe, which keeps estimating stiffness.
pub const SECURE: Selection = Selection::from_modules(&[
    ModuleId::FIRST_TOUCH,
    ModuleId::PROBE,
    ModuleId::SLIP,
    ModuleId::FORCE_LIMIT,
]);
/// Modules that hold with minimum force.
const HOLD: Selection = SECURE.union(Selection::from_modules(&[ModuleId::RELAX]));
const LIFT: Selection = HOLD.union(Selection::from_modules(&[
    ModuleId::CARRY,
    ModuleId::LIFT_VERIFICATION,
]));

pub(super) const REACH: Step = Step::new(
    "reach",
    Motion::Reach(Waypoint::BeforeSource),
    FREE,
    Transition::Arrived,
    20.0,
);
pub(super) const DESCEND: Step = Step::new(
    "descend",
    Motion::Reach(Waypoint::Source),
    FREE,
    Transition::Arrived,
    10.0,
);
pub(super) const APPROACH: Step = Step::new(
    "approach",
    Motion::Stay,
    TOUCH,
    Transition::AllTouched,
    20.0,
);
pub(super) const PROBE_IT: Step = Step::new(
    "probe",
    Motion::Stay,
    PROBE,
    Transition::StiffnessKnown,
    3.0,
);
pub(super) const GRASP_IT: Step = Step::new("grip", Motion::Stay, GRIP, Transition::Gripped, 5.0);
const LIFT_IT: Step = Step::new(
    "lift",
    Motion::Carry(Waypoint::Lifted),
    LIFT,
    Transition::Arrived,
    120.0,
);
pub(super) const OPEN: Step = Step::new("open", Motion::Open, CARRY, Transition::Arrived, 10.0);
pub(super) const LEAVE: Step = Step::new(
    "leave",
    Motion::Reach(Waypoint::Above),
    CARRY,
    Transition::Arrived,
    10.0,
);
pub(super) const GO_HOME: Step = Step::new(
    "home",
    Motion::Reach(Waypoint::Home),
    CARRY,
    Transition::Arrived,
    20.0,
);
const HOLD_IT: Step = Step::new("hold", Motion::Stay, HOLD, Transition::Held, f64::INFINITY);

/// Grasps, lifts and holds. The last step stays active after success.
pub static GRASP: Task = Task::one_handed(
    "grasp",
    &[
        REACH, DESCEND, APPROACH, PROBE_IT, GRASP_IT, LIFT_IT, HOLD_IT,
    ],
);

/// Holds the object when a goal ends.
pub const HOLD_AFTER_GOAL: StepSequence = StepSequence::from_steps(&[HOLD_IT]);

/// Holds an object found in the hand: modules 2 and 3, without grip relaxation.
pub const HOLD_FOUND: StepSequence = StepSequence::from_steps(&[Step::new(
    "keep grip",
    Motion::Stay,
    Selection::from_modules(&[ModuleId::SLIP, ModuleId::FORCE_LIMIT]),
    Transition::Held,
    f64::INFINITY,
)]);

/// Puts back a rejected object: lower, open, leave.
pub const PUT_BACK: StepSequence = StepSequence::from_steps(&[
    Step::new(
        "lower",
        Motion::Carry(Waypoint::Source),
        LOWER,
        Transition::Arrived,
        60.0,
    ),
    OPEN,
    Step::new(
        "leave",
        Motion::Reach(Waypoint::BeforeSource),
        CARRY,
        Transition::Arrived,
        10.0,
    ),
]);

/// Puts back or releases the object and returns for a corrected grasp.
pub const REGRASP: StepSequence = StepSequence::from_steps(&[
    Step::new(
        "put back",
        Motion::Carry(Waypoint::Source),
        LOWER,
        Transition::Arrived,
        60.0,
    ),
    Step::new("reopen", Motion::Open, CARRY, Transition::Arrived, 10.0),
    Step::new(
        "regrasp",
        Motion::Reach(Waypoint::Source),
        FREE,
        Transition::Arrived,
        10.0,
    ),
]);

/// Withdraws from an obstacle along the approach path.
pub const WITHDRAW: StepSequence = StepSequence::from_steps(&[Step::new(
    "withdraw",
    Motion::Withdraw,
    CARRY,
    Transition::Arrived,
    20.0,
)]);

/// Opens the hand in place and moves it home.
pub static RELEASE: Task = Task::one_handed("release", &[OPEN, LEAVE, GO_HOME]);
