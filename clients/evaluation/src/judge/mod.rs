//! The judge: what truly became of a task.
//!
//! **In:** the goal's last update, the simulator's truth, what physics allows. **Out:** a finding per task, which is a
//! success or names its failure by a key that reports count. The judge looks at what the controller never sees, and
//! never at an object's name.
//!
//! | task | success |
//! |---|---|
//! | grasp | [`Outcome`]: held if physics allows it, else put back unharmed, upright and where it was |
//! | pick and place | [`Placing`]: within 5 mm, opened within 20 ms of support and not above it, unharmed |
//! | screw | [`Screwing`]: closed, to 1.3 to 2.5 × the thread's friction |
//! | assembly | [`Assembly`]: bottle standing and not turned, cap closed as tight as in screwing |
//!
//! In no task may an object slip more than 3 mm or turn more than 10° in the hand that carries it.

mod assembly;
mod grasp;
mod load;
mod pick_place;
mod screw;
#[cfg(test)]
mod tests;

pub use assembly::Assembly;
pub use grasp::Outcome;
pub use load::Load;
pub use pick_place::Placing;
pub use screw::Screwing;

use shm_schemas::{GoalState, GoalUpdate, ObjectTruth};

/// Farthest that an object may slip in the hand, m (issue).
pub const SLIP_MAX_M: f64 = 0.003;
/// Farthest that an object may turn in the hand, rad (issue: 10°).
pub const TURN_MAX_RAD: f64 = 10.0 * core::f64::consts::PI / 180.0;
/// How tight a closed cap is, times the friction of its thread (issue).
const TIGHT: [f64; 2] = [1.3, 2.5];

/// How an object was kept in the hand that carried it last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kept {
    /// As it was taken, within [`SLIP_MAX_M`] and [`TURN_MAX_RAD`].
    AsTaken,
    Slipped,
    Turned,
}

/// A number that is not finite is within no limit.
fn kept(object: &ObjectTruth) -> Kept {
    let stuck = object.slip_in_hand_m <= SLIP_MAX_M;
    let straight = object.turn_in_hand_rad <= TURN_MAX_RAD;
    match (stuck, straight) {
        (false, _) => Kept::Slipped,
        (_, false) => Kept::Turned,
        _ => Kept::AsTaken,
    }
}

/// The key of an object that was not kept as it was taken; `None` if it was.
fn moved_in_hand(object: &ObjectTruth) -> Option<String> {
    match kept(object) {
        Kept::AsTaken => None,
        Kept::Slipped => Some("slipped in the hand".to_owned()),
        Kept::Turned => Some("turned in the hand".to_owned()),
    }
}

/// The key of a cap that is not on its thread, or not as tight as it shall be; `None` if it is.
fn loose(cap: &ObjectTruth) -> Option<String> {
    let tightness = cap.cap_holding_n_m / cap.cap_friction_n_m;
    unless(cap.cap_engaged != 0, "off its thread")
        .or_else(|| unless(tightness >= TIGHT[0], "early"))
        .or_else(|| unless(tightness <= TIGHT[1], "too tight"))
}

/// The key of a goal that did not succeed, by the controller's own account; `None` if it did.
fn ended(end: &GoalUpdate) -> Option<String> {
    let (cause, step) = (end.reason.cause, end.step.as_str());
    match end.state {
        GoalState::SUCCEEDED => None,
        GoalState::REFUSED => Some(format!("refused: {cause}")),
        _ if step.is_empty() => Some(format!("failed: {cause}")),
        _ => Some(format!("failed in {step}: {cause}")),
    }
}

/// The key of an object that came to harm; `None` if it did not.
fn harmed(object: &ObjectTruth) -> Option<String> {
    let harms = [
        (object.crushed, "crushed"),
        (object.dropped, "dropped"),
        (object.tipped, "tipped"),
        (object.spilt, "spilt"),
    ];
    let harm = harms.into_iter().find(|(happened, _)| *happened != 0);
    harm.map(|(_, key)| key.to_owned())
}

/// The key, if the condition does not hold; a number that is not finite fulfils none.
fn unless(holds: bool, key: &str) -> Option<String> {
    (!holds).then(|| key.to_owned())
}
