//! The grasp: what physics allows for an object, and what became of it.

use atas_core::settings;
use atas_core::thresholds::Thresholds;
use shm_schemas::{Cause, GoalState, GoalUpdate, ObjectTruth, WorldTruth};
use sim_backend::Object;

/// Share of the lift that an object must truly have risen to count as lifted (ours: leaves room for a slip that was
/// caught, and none for an object that stayed behind).
const LIFTED_SHARE: f64 = 0.5;
/// Normal force of a finger that still presses, N (ours: half of the controller's own touch threshold).
const PRESSED_N: f64 = 0.03;
/// An object is borderline if the force it needs is within this share of F_2. Measured with `atas eval grasp --seeds 25`:
/// of soft objects the stiffness probe finds F_2 too high by 5 to 9 %, with a standard deviation of 4 %.
const BORDERLINE_SHARE: f64 = 0.15;

/// The forces that decide whether an object can be held. All per finger, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Normal force that carries it by friction: m·g / (2·μ), with the true static friction.
    pub needed_n: f64,
    /// Normal force that crushes it.
    pub crush_n: f64,
    /// F_2 that the law in force gives for its true stiffness.
    pub f2_n: f64,
}

impl Load {
    /// Of a true object under the law with these settings.
    #[must_use]
    pub fn of(object: &Object, grasp: &settings::Grasp) -> Self {
        Self {
            needed_n: object.needed_n(),
            crush_n: object.crush_n,
            f2_n: Thresholds::for_stiffness(object.stiffness_n_m, grasp).f2_n,
        }
    }

    /// Of an object as the simulator judges it, with the true stiffness of its data file.
    #[must_use]
    pub fn of_truth(truth: &ObjectTruth, stiffness_n_m: f64, grasp: &settings::Grasp) -> Self {
        Self {
            needed_n: truth.needed_n,
            crush_n: truth.crush_n,
            f2_n: Thresholds::for_stiffness(stiffness_n_m, grasp).f2_n,
        }
    }

    /// Feasible: the force it needs is below F_2, and does not crush it. Every object is one or the other by this plain
    /// definition, borderline or not.
    #[must_use]
    pub fn is_feasible(&self) -> bool {
        self.needed_n < self.f2_n && self.needed_n < self.crush_n
    }

    /// Borderline: so near to F_2 that the measured stiffness may rightly decide either way. Reported beside the counts,
    /// never taken out of them.
    #[must_use]
    pub fn is_borderline(&self) -> bool {
        (self.needed_n / self.f2_n - 1.0).abs() < BORDERLINE_SHARE
    }
}

/// What truly became of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Lifted, in the hand after the hold, neither crushed nor dropped, and the goal succeeded.
    Held,
    /// Put back and left unharmed, with the controller's reason.
    Refused(Cause),
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
        let pressed = truth.normal_n[hand][..robot_model::FINGERS]
            .iter()
            .all(|force_n| *force_n > PRESSED_N);
        match end.state {
            GoalState::SUCCEEDED if pressed && object.lifted_m >= LIFTED_SHARE * lift_m => {
                Self::Held
            }
            GoalState::SUCCEEDED => Self::NotLifted,
            GoalState::REFUSED => Self::Refused(end.reason.cause),
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
            Self::Refused(cause) | Self::Failed(cause) => format!("{}: {cause}", self.name()),
            _ => self.name().to_owned(),
        }
    }
}

#[cfg(test)]
mod tests;
