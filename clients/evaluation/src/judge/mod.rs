//! The judge: what truly became of a task.
//!
//! **In:** the goal's last update, the simulator's truth, what physics allows. **Out:** a finding per task, which is a
//! success or names its failure by a key that reports count. The judge looks at what the controller never sees, and
//! never at an object's name.
//!
//! | task | success |
//! |---|---|
//! | grasp | [`Outcome`]: held if physics allows it, else put back unharmed |
//! | pick and place | [`Placing`]: within 5 mm, opened within 20 ms of support and not above it, unharmed |
//! | screw | [`Screwing`]: closed, to 1.3 to 2.5 × the thread's friction |
//! | assembly | [`Assembly`]: bottle standing, cap closed |

mod assembly;
mod grasp;
mod pick_place;
mod screw;
#[cfg(test)]
mod tests;

pub use assembly::Assembly;
pub use grasp::{Load, Outcome};
pub use pick_place::Placing;
pub use screw::Screwing;

use shm_schemas::{GoalState, GoalUpdate, ObjectTruth};

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
