//! The grasp: what became of an object.

use shm_schemas::{Cause, GoalState, GoalUpdate, WorldTruth};

use super::{Kept, kept};

/// Share of the lift that an object must truly have risen to count as lifted (ours: leaves room for a slip that was
/// caught, and none for an object that stayed behind).
const LIFTED_SHARE: f64 = 0.5;
/// Normal force of a finger that still presses, N (ours: half of the controller's own touch threshold).
const PRESSED_N: f64 = 0.03;

/// What truly became of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Lifted, in the hand after the hold as it was taken, neither crushed nor dropped, and the goal succeeded.
    Held,
    /// Left unharmed, upright and where it was, with the controller's reason.
    Refused(Cause),
    /// Refused, but it does not stand upright where it was.
    Displaced(Cause),
    /// In the lifted hand, but it slipped there farther than [`super::SLIP_MAX_M`].
    Slipped,
    /// In the lifted hand, but it turned there farther than [`super::TURN_MAX_RAD`].
    Turned,
    /// Crushed, whatever else happened.
    Crushed,
    /// Dropped, whatever the controller thinks.
    Dropped,
    /// The controller reports success, but the object is not in the lifted hand.
    NotLifted,
    /// The goal ended without success for another reason than the object.
    Failed(Cause),
}

impl Outcome {
    /// The outcome of a goal for the first object and the hand with this index.
    #[must_use]
    pub fn of(end: &GoalUpdate, truth: &WorldTruth, hand: usize, lift_m: f64) -> Self {
        let object = &truth.objects[0];
        if object.crushed != 0 {
            return Self::Crushed;
        }
        if object.dropped != 0 {
            return Self::Dropped;
        }
        let pressed = truth.normal_n[hand][..robot_model::VIRTUAL_FINGERS]
            .iter()
            .all(|force_n| *force_n > PRESSED_N);
        match end.state {
            GoalState::SUCCEEDED if pressed && object.lifted_m >= LIFTED_SHARE * lift_m => {
                match kept(object) {
                    Kept::AsTaken => Self::Held,
                    Kept::Slipped => Self::Slipped,
                    Kept::Turned => Self::Turned,
                }
            }
            GoalState::SUCCEEDED => Self::NotLifted,
            GoalState::REFUSED if object.stands != 0 => Self::Refused(end.reason.cause),
            GoalState::REFUSED => Self::Displaced(end.reason.cause),
            _ => Self::Failed(end.reason.cause),
        }
    }

    /// Whether it is what should become of an object of this feasibility.
    #[must_use]
    pub fn is_expected(self, feasible: bool) -> bool {
        match self {
            Self::Held => feasible,
            Self::Refused(_) => !feasible,
            _ => false,
        }
    }

    /// One word for tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Held => "held",
            Self::Refused(_) => "refused",
            Self::Displaced(_) => "displaced",
            Self::Slipped => "slipped in the hand",
            Self::Turned => "turned in the hand",
            Self::Crushed => "crushed",
            Self::Dropped => "dropped",
            Self::NotLifted => "not-lifted",
            Self::Failed(_) => "failed",
        }
    }

    /// The key under which an unexpected outcome is counted: the word, with the controller's step and cause where it has
    /// them.
    #[must_use]
    pub fn key(self, step: &str) -> String {
        match self {
            Self::Failed(cause) if !step.is_empty() => format!("failed in {step}: {cause}"),
            Self::Refused(cause) | Self::Displaced(cause) | Self::Failed(cause) => {
                format!("{}: {cause}", self.name())
            }
            _ => self.name().to_owned(),
        }
    }
}

#[cfg(test)]
mod tests;
