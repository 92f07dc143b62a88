//! Following a client's targets: modules 1, 2 and 3 beneath whatever leads the hand.
//!
//! The hand follows, opened as the client wants, until the client wants something held, or the fingers meet something on their
//! way together. Then it stands while the fingers take hold as in a grasp: touch, probe, F_1. Held, the object goes
//! where the client leads the hand, until the client wants the hand wider than the object: then everything begins again.
//!
//! Nothing gives back force: whoever is led has no time to feel his way to the edge of slipping.

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

/// One hand that a client leads.
pub static FOLLOW: Task = Task::of("follow", &STEPS);

/// Both hands.
pub static FOLLOW_BOTH: Task = Task {
    helping: Some(Track::of(&STEPS)),
    ..Task::of("follow-both", &STEPS)
};

/// Brakes and keeps holding when the stream ends.
pub const STAND_LED: Track = Track::of(&[Step::new(
    "hold",
    Motion::Brake,
    SECURE.and(LED),
    Transition::Held,
    f64::INFINITY,
)]);
