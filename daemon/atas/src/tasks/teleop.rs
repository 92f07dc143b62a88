//! Teleoperation: modules 1, 2 and 3 combined with a client's target stream.
//!
//! The hand tracks the target until the client requests a grip or the closing fingers touch
//! something. It then stops and grips: touch, probe, F_1. The gripped object tracks the target
//! until the client requests an opening wider than the object.
//!
//! No module relaxes the grip, because teleoperation leaves no time for it.

use super::grasp::{GRIP, PROBE, SECURE, TOUCH};
use super::step::{Motion, Step, Transition};
use super::step_sequence::{StepSequence, Task};
use crate::modules::Selection;
use shm_schemas::ModuleId;

const TELEOP_MODULES: Selection = Selection::from_modules(&[ModuleId::TELEOP]);

const STEPS: [Step; 5] = [
    Step::new(
        "teleop",
        Motion::Teleop,
        TELEOP_MODULES,
        Transition::GripRequested,
        f64::INFINITY,
    ),
    Step::new(
        "approach",
        Motion::Brake,
        TOUCH.union(TELEOP_MODULES),
        Transition::AllTouched,
        20.0,
    ),
    Step::new(
        "probe",
        Motion::Brake,
        PROBE.union(TELEOP_MODULES),
        Transition::StiffnessKnown,
        3.0,
    ),
    Step::new(
        "grip",
        Motion::Brake,
        GRIP.union(TELEOP_MODULES),
        Transition::Gripped,
        5.0,
    ),
    Step::new(
        "carry",
        Motion::Teleop,
        SECURE.union(TELEOP_MODULES),
        Transition::OpeningRequested,
        f64::INFINITY,
    ),
];

/// Teleoperates one hand.
pub static TELEOP: Task = Task::one_handed("teleop", &STEPS);

/// Teleoperates both hands.
pub static TELEOP_BOTH: Task = Task {
    helping: Some(StepSequence::from_steps(&STEPS)),
    ..Task::one_handed("teleop-both", &STEPS)
};

/// Brakes and holds the object when the stream ends.
pub const HOLD_AFTER_TELEOP: StepSequence = StepSequence::from_steps(&[Step::new(
    "hold",
    Motion::Brake,
    SECURE.union(TELEOP_MODULES),
    Transition::Held,
    f64::INFINITY,
)]);
