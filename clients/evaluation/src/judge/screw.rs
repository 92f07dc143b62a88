//! Evaluation of cap screwing: tightness of the cap.

use shm_schemas::{Cause, GoalUpdate, WorldTruth};

use super::{ended, harmed, loose, moved_in_hand, unless};

/// Result of a screwing.
#[derive(Clone, Debug, PartialEq)]
pub struct Screwing {
    /// Failure key.
    pub failure: Option<String>,
    /// Holding torque of the cap over its thread's friction.
    pub tightness: f64,
    /// Rotation of the cap over the angle at which it closes.
    pub turned: f64,
}

impl Screwing {
    /// Evaluates the first object, a cap.
    #[must_use]
    pub fn of(end: &GoalUpdate, truth: &WorldTruth) -> Self {
        let cap = &truth.objects[0];
        let tightness = cap.cap_holding_n_m / cap.cap_friction_n_m;
        let failure = harmed(cap)
            .or_else(|| never(end))
            .or_else(|| ended(end))
            .or_else(|| loose(cap))
            .or_else(|| moved_in_hand(cap));
        Self {
            failure,
            tightness,
            turned: cap.cap_angle_rad / cap.cap_closing_rad,
        }
    }
}

fn never(end: &GoalUpdate) -> Option<String> {
    unless(end.reason.cause != Cause::TIMED_OUT, "never")
}
