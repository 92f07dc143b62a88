//! Evaluation of a grasp.

use robot_model::HandModel;
use shm_schemas::{Cause, GoalState, GoalUpdate, WorldTruth};

use super::{InHandMotion, in_hand_motion};

/// Share of the commanded lift above which an object counts as lifted. Design choice: accepts a
/// stopped slip, rejects an object left behind.
const LIFTED_SHARE: f64 = 0.5;
/// Normal force above which a grasp side is in contact, N. Design choice: half the controller's
/// touch threshold.
const CONTACT_N: f64 = 0.03;

/// True outcome for an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Goal succeeded; lifted, stable in the hand and unharmed.
    Held,
    /// Left unharmed, upright and in place, with the controller's reason.
    Refused(Cause),
    /// Refused, but not upright in place.
    Displaced(Cause),
    /// In the lifted hand, but slipped more than [`super::SLIP_MAX_M`].
    Slipped,
    /// In the lifted hand, but turned more than [`super::TURN_MAX_RAD`].
    Turned,
    /// Crushed, whatever the goal state.
    Crushed,
    /// Dropped, whatever the goal state.
    Dropped,
    /// Goal succeeded, but the object is not in the lifted hand.
    NotLifted,
    /// Goal ended without success for a reason other than the object.
    Failed(Cause),
}

impl Outcome {
    /// Returns the outcome for the first object and this hand.
    #[must_use]
    pub fn evaluate(end: &GoalUpdate, truth: &WorldTruth, hand: &HandModel, lift_m: f64) -> Self {
        let object = &truth.objects[0];
        if object.crushed != 0 {
            return Self::Crushed;
        }
        if object.dropped != 0 {
            return Self::Dropped;
        }
        let normal_n = &truth.normal_n[hand.side().index()];
        let pressed = hand
            .grasp_sides()
            .both_exceed(CONTACT_N, |fingertip| normal_n[fingertip]);
        match end.state {
            GoalState::SUCCEEDED if pressed && object.lifted_m >= LIFTED_SHARE * lift_m => {
                match in_hand_motion(object) {
                    InHandMotion::Stable => Self::Held,
                    InHandMotion::Slipped => Self::Slipped,
                    InHandMotion::Turned => Self::Turned,
                }
            }
            GoalState::SUCCEEDED => Self::NotLifted,
            GoalState::REFUSED if object.stands != 0 => Self::Refused(end.reason.cause),
            GoalState::REFUSED => Self::Displaced(end.reason.cause),
            _ => Self::Failed(end.reason.cause),
        }
    }

    /// Returns true if the outcome is right for this feasibility.
    #[must_use]
    pub fn is_expected(self, feasible: bool) -> bool {
        match self {
            Self::Held => feasible,
            Self::Refused(_) => !feasible,
            _ => false,
        }
    }

    /// Returns the name for tables.
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

    /// Returns the failure key: the name, with the controller's step and cause if it has them.
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
