//! Teleoperation: modules 1, 2 and 3 combined with a client's target stream.
//!
//! The hand tracks the target until the client requests a grip or the closing fingers touch
//! something. It then stops and grips: touch, probe, F_1. The gripped object tracks the target
//! until the client requests an opening wider than the object.
//!
//! No module relaxes the grip, because teleoperation leaves no time for it.

use super::grasp::{GRIP, PROBE, SECURE, TOUCH};
use super::step::{Motion, Step, Transition};
use super::track::{Task, Track};
use crate::modules::Selection;
use shm_schemas::ModuleId;

const LED: Selection = Selection::of(&[ModuleId::FOLLOW]);

const STEPS: [Step; 5] = [
    Step::new(
        "follow",
        Motion::Follow,
        LED,
        Transition::GripWanted,
        f64::INFINITY,
    ),
    Step::new(
        "approach",
        Motion::Brake,
        TOUCH.and(LED),
        Transition::AllTouched,
        20.0,
    ),
    Step::new(
        "probe",
        Motion::Brake,
        PROBE.and(LED),
        Transition::StiffnessKnown,
        3.0,
    ),
    Step::new(
        "grip",
        Motion::Brake,
        GRIP.and(LED),
        Transition::Gripped,
        5.0,
    ),
    Step::new(
        "carry",
        Motion::Follow,
        SECURE.and(LED),
        Transition::OpeningWanted,
        f64::INFINITY,
    ),
];

/// Teleoperates one hand.
pub static FOLLOW: Task = Task::of("follow", &STEPS);

/// Teleoperates both hands.
pub static FOLLOW_BOTH: Task = Task {
    helping: Some(Track::of(&STEPS)),
    ..Task::of("follow-both", &STEPS)
};

/// Brakes and holds the object when the stream ends.
pub const STAND_LED: Track = Track::of(&[Step::new(
    "hold",
    Motion::Brake,
    SECURE.and(LED),
    Transition::Held,
    f64::INFINITY,
)]);
