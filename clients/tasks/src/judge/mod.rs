//! Evaluation of a task's outcome against ground truth.
//!
//! **In:** the goal's last update, the simulator's ground truth, the forces that decide
//! feasibility. **Out:** a result per task: success, or a failure key that reports count. The judge
//! uses data that the controller cannot access, but never an object's name.
//!
//! | task | success |
//! |---|---|
//! | grasp | [`Outcome`]: held if feasible, else put back unharmed, upright and in place |
//! | pick and place | [`Placing`]: within 5 mm, opened within 20 ms of support and not above it |
//! | screw | [`Screwing`]: closed to 1.3 to 2.5 × the thread's friction |
//! | assembly | [`Assembly`]: bottle standing and not turned, cap closed as in screwing |
//!
//! In every task, an object may slip at most 3 mm and turn at most 10° in the carrying hand.
//! [`HiddenMotion`] counts separately where the controller reports success beyond these limits.

mod assembly;
mod grasp;
mod hidden;
mod load;
mod pick_place;
mod screw;
#[cfg(test)]
mod tests;

pub use assembly::Assembly;
pub use grasp::Outcome;
pub use hidden::HiddenMotion;
pub use load::Load;
pub use pick_place::Placing;
pub use screw::Screwing;

use shm_schemas::{GoalState, GoalUpdate, ObjectTruth};

/// Largest slip in the hand, m (acceptance criterion).
pub const SLIP_MAX_M: f64 = 0.003;
/// Largest turn in the hand, rad (acceptance criterion: 10°).
pub const TURN_MAX_RAD: f64 = 10.0 * core::f64::consts::PI / 180.0;
/// Range of a closed cap's tightness: holding torque over friction torque of the thread (acceptance
/// criterion).
const TIGHTNESS_RANGE: [f64; 2] = [1.3, 2.5];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum InHandMotion {
    Stable,
    Slipped,
    Turned,
}

/// Compares slip and turn with their limits; a value that is not finite exceeds them.
fn in_hand_motion(object: &ObjectTruth) -> InHandMotion {
    let stuck = object.slip_in_hand_m <= SLIP_MAX_M;
    let straight = object.turn_in_hand_rad <= TURN_MAX_RAD;
    match (stuck, straight) {
        (false, _) => InHandMotion::Slipped,
        (_, false) => InHandMotion::Turned,
        _ => InHandMotion::Stable,
    }
}

fn in_hand_failure(object: &ObjectTruth) -> Option<String> {
    match in_hand_motion(object) {
        InHandMotion::Stable => None,
        InHandMotion::Slipped => Some("slipped in the hand".to_owned()),
        InHandMotion::Turned => Some("turned in the hand".to_owned()),
    }
}

/// Returns the failure key of a cap that is off its thread or outside the tightness range.
fn cap_failure(cap: &ObjectTruth) -> Option<String> {
    let tightness = cap.cap_holding_n_m / cap.cap_friction_n_m;
    failure_unless(cap.cap_engaged != 0, "off its thread")
        .or_else(|| failure_unless(tightness >= TIGHTNESS_RANGE[0], "too loose"))
        .or_else(|| failure_unless(tightness <= TIGHTNESS_RANGE[1], "too tight"))
}

fn goal_failure(end: &GoalUpdate) -> Option<String> {
    let (cause, step) = (end.reason.cause, end.step.as_str());
    match end.state {
        GoalState::SUCCEEDED => None,
        GoalState::REFUSED => Some(format!("refused: {cause}")),
        _ if step.is_empty() => Some(format!("failed: {cause}")),
        _ => Some(format!("failed in {step}: {cause}")),
    }
}

fn harm(object: &ObjectTruth) -> Option<String> {
    let harms = [
        (object.crushed, "crushed"),
        (object.dropped, "dropped"),
        (object.tipped, "tipped"),
        (object.spilt, "spilt"),
    ];
    let harm = harms.into_iter().find(|(happened, _)| *happened != 0);
    harm.map(|(_, key)| key.to_owned())
}

/// Returns the key if the condition is false. Comparisons with NaN are false.
fn failure_unless(holds: bool, key: &str) -> Option<String> {
    (!holds).then(|| key.to_owned())
}
