//! The judge: what physics allows for an object, and what truly became of it.
//!
//! **In:** the true object or the simulator's truth, the law of F_2, the goal's last update. **Out:** [`Load`] and
//! [`Outcome`]. The judge looks at what the controller never sees, and never at an object's name.

use atas::settings;
use atas::tasks::Thresholds;
use shm_schemas::{Cause, GoalState, GoalUpdate, ObjectTruth, WorldTruth};
use sim_backend::Object;

/// Share of the lift that an object must truly have risen to count as lifted (ours: leaves room for a slip that was
/// caught, and none for an object that stayed behind).
const LIFTED_SHARE: f64 = 0.5;
/// Normal force of a finger that still presses, N (ours: half of the controller's own touch threshold).
const PRESSED_N: f64 = 0.03;
/// An object is borderline if the force it needs is within this share of F_2. Measured with `atas eval grasp --seeds 25`:
/// of soft objects the hardness probe finds F_2 too high by 5 to 9 %, with a standard deviation of 4 %.
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

    /// Borderline: so near to F_2 that the measured hardness may rightly decide either way. Reported beside the counts,
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
mod tests {
    use super::*;
    use shm_schemas::Reason;

    const LIFT_M: f64 = 0.04;

    fn truth(lifted_m: f64, pressed_n: f64) -> WorldTruth {
        let mut truth = WorldTruth::default();
        truth.objects[0].lifted_m = lifted_m;
        truth.normal_n[1] = [pressed_n; 4];
        truth
    }

    fn end(state: GoalState, cause: Cause) -> GoalUpdate {
        GoalUpdate {
            state,
            reason: Reason::of(cause),
            ..GoalUpdate::default()
        }
    }

    #[test]
    fn outcomes() {
        let check = |state, cause, truth: WorldTruth, expected: Outcome| {
            assert_eq!(
                Outcome::of(&end(state, cause), &truth, 1, LIFT_M),
                expected,
                "{state} {cause}"
            );
        };
        let crushed = |mut truth: WorldTruth| {
            truth.objects[0].crushed = 1;
            truth
        };
        let dropped = |mut truth: WorldTruth| {
            truth.objects[0].dropped = 1;
            truth
        };
        let (done, none) = (GoalState::SUCCEEDED, Cause::NONE);
        check(done, none, truth(0.039, 5.0), Outcome::Held);
        check(done, none, truth(0.019, 5.0), Outcome::NotLifted);
        check(done, none, truth(0.039, 0.0), Outcome::NotLifted);
        check(done, none, truth(f64::NAN, 5.0), Outcome::NotLifted);
        check(done, none, crushed(truth(0.039, 5.0)), Outcome::Crushed);
        check(done, none, dropped(truth(0.039, 5.0)), Outcome::Dropped);
        let heavy = Cause::TOO_HEAVY;
        let refused = Outcome::Refused(heavy);
        check(GoalState::REFUSED, heavy, truth(0.0, 0.0), refused);
        check(
            GoalState::REFUSED,
            heavy,
            crushed(truth(0.0, 0.0)),
            Outcome::Crushed,
        );
        let busy = Cause::BUSY;
        check(
            GoalState::REJECTED,
            busy,
            truth(0.0, 0.0),
            Outcome::Failed(busy),
        );
    }

    #[test]
    fn keys_of_failures() {
        let check = |outcome: Outcome, step, expected| assert_eq!(outcome.key(step), expected);
        check(Outcome::Crushed, "lift", "crushed");
        check(
            Outcome::Refused(Cause::TOO_HEAVY),
            "leave",
            "refused: too-heavy",
        );
        check(
            Outcome::Failed(Cause::TIMED_OUT),
            "grip",
            "failed in grip: timed-out",
        );
        check(
            Outcome::Failed(Cause::UNREACHABLE),
            "",
            "failed: unreachable",
        );
    }

    #[test]
    fn only_held_and_refused_are_ever_expected() {
        let heavy = Cause::TOO_HEAVY;
        let check = |outcome: Outcome, feasible: bool, expected: bool| {
            assert_eq!(
                outcome.is_expected(feasible),
                expected,
                "{outcome:?} {feasible}"
            );
        };
        check(Outcome::Held, true, true);
        check(Outcome::Held, false, false);
        check(Outcome::Refused(heavy), true, false);
        check(Outcome::Refused(heavy), false, true);
        for outcome in [
            Outcome::Crushed,
            Outcome::Dropped,
            Outcome::NotLifted,
            Outcome::Failed(heavy),
        ] {
            check(outcome, true, false);
            check(outcome, false, false);
        }
    }

    #[test]
    fn feasibility_is_physics() {
        let check = |needed_n, crush_n, f2_n, feasible, borderline| {
            let load = Load {
                needed_n,
                crush_n,
                f2_n,
            };
            assert_eq!(
                (load.is_feasible(), load.is_borderline()),
                (feasible, borderline),
                "{load:?}"
            );
        };
        check(2.9, f64::INFINITY, 8.0, true, false);
        check(18.4, f64::INFINITY, 8.0, false, false);
        check(1.47, 1.5, 0.75, false, false);
        check(0.25, 1.5, 0.75, true, false);
        check(1.6, 1.5, 8.0, false, false);
        check(7.9, f64::INFINITY, 8.0, true, true);
        check(8.0, f64::INFINITY, 8.0, false, true);
        check(f64::NAN, f64::INFINITY, 8.0, false, false);
    }

    #[test]
    fn the_law_is_taken_at_the_true_stiffness() {
        let grasp = settings::Grasp::default();
        let f2_n = |name: &str| {
            let object = Object::built_in(name).expect("built in");
            Load::of(&object, &grasp).f2_n
        };
        assert!((f2_n("wood") - 8.0).abs() < 1e-12, "rigid: the upper bound");
        assert!(
            (f2_n("paper-box") - 0.75).abs() < 1e-12,
            "0.5 mm × 1500 N/m"
        );
        assert!(
            (f2_n("sponge") - 0.7).abs() < 1e-12,
            "soft: the lower bound"
        );
    }
}
