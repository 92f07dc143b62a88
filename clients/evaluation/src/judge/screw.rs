//! Cap screwing: how tight the cap is.

use shm_schemas::{Cause, GoalUpdate, WorldTruth};

use super::{ended, harmed, loose, moved_in_hand, unless};

/// What became of a screwing.
#[derive(Clone, Debug, PartialEq)]
pub struct Screwing {
    /// Why it is no success; `None` if it is.
    pub failure: Option<String>,
    /// Torque that it takes to turn the cap any further over the friction of its thread.
    pub tightness: f64,
    /// How far the cap was turned over the angle at which it closes.
    pub turned: f64,
}

impl Screwing {
    /// Of the first object, a cap.
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

/// The key of a screwing that was not concluded in time.
fn never(end: &GoalUpdate) -> Option<String> {
    unless(end.reason.cause != Cause::TIMED_OUT, "never")
}
