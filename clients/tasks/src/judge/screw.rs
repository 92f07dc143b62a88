//! Evaluation of cap screwing: tightness of the cap.

use shm_schemas::{GoalUpdate, Reason, WorldTruth};

use super::{cap_failure, failure_unless, goal_failure, harm, in_hand_failure};

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
    pub fn evaluate(end: &GoalUpdate, truth: &WorldTruth) -> Self {
        let cap = &truth.objects[0];
        let tightness = cap.cap_holding_n_m / cap.cap_friction_n_m;
        let failure = harm(cap)
            .or_else(|| timeout_failure(end))
            .or_else(|| goal_failure(end))
            .or_else(|| cap_failure(cap))
            .or_else(|| in_hand_failure(cap));
        Self {
            failure,
            tightness,
            turned: cap.cap_angle_rad / cap.cap_closing_rad,
        }
    }
}

fn timeout_failure(end: &GoalUpdate) -> Option<String> {
    let is_late = matches!(Reason::from(end.reason), Reason::TimedOut { .. });
    failure_unless(!is_late, "timed out")
}
