//! Fitness of a grasp, as in the paper: accuracy, efficiency, and a guard against accidents.
//!
//! Up to 100 points per object. E₁ = 60 for the expected verdict (held or refused) of the
//! evaluation. E₂ = 20 for time and 20 for a low grip force, only if the object is held at both
//! checks without creep: on arrival and after 1 s of holding. Failed grasps earn few points for
//! partial progress, so that the roulette can select among them.

use pinch::{End, HOLD_S, LIFT_M, Object, Outcome};

/// Points for accuracy, and the two parts of efficiency.
const VERDICT_POINTS: f32 = 60.0;
const TIME_POINTS: f32 = 20.0;
const LOW_FORCE_POINTS: f32 = 20.0;
/// Points of an accident: held at the end, but not at both checks, or creeping.
const ACCIDENT_POINTS: f32 = 30.0;
/// Points if a feasible object is refused, and if an infeasible one is left standing.
const WRONG_REFUSAL_POINTS: f32 = 5.0;
const LEFT_STANDING_POINTS: f32 = 20.0;
/// Largest points for a partial lift.
const PARTIAL_LIFT_POINTS: f32 = 10.0;
/// Share of the lift that counts as lifted; largest slip in the hand, m (values of the evaluation).
const LIFTED_SHARE: f32 = 0.5;
const SLIP_MAX_M: f32 = 0.003;
/// Largest slip between the two checks, m.
const CREEP_MAX_M: f32 = 0.001;
/// Duration of an undelayed lift, and the delay that earns no time points, s. A refusal may take as
/// long as the delay.
const LIFT_S: f32 = 4.0 + HOLD_S;
const DELAY_MAX_S: f32 = 3.0;

/// Returns the points of one grasp, 0 to 100.
#[must_use]
pub fn points(object: &Object, outcome: &Outcome) -> f32 {
    let kept = |judgement: usize| {
        outcome.raised_m[judgement] >= LIFTED_SHARE * LIFT_M
            && outcome.slip_m[judgement] <= SLIP_MAX_M
    };
    let share = |value: f32| value.clamp(0.0, 1.0);
    let lifting = PARTIAL_LIFT_POINTS * share(outcome.raised_m[1] / LIFT_M);
    match (outcome.end, object.is_feasible()) {
        (End::Crushed | End::Lost, _) => 0.0,
        (End::Arrived, true) if kept(0) && kept(1) => {
            if outcome.slip_m[1] - outcome.slip_m[0] > CREEP_MAX_M {
                return ACCIDENT_POINTS;
            }
            let late_s = outcome.time_s - LIFT_S;
            let in_time = TIME_POINTS * share(1.0 - late_s / DELAY_MAX_S);
            VERDICT_POINTS
                + in_time
                + LOW_FORCE_POINTS * share(object.required_n() / outcome.normal_n)
        }
        (End::Arrived, true) if kept(1) => ACCIDENT_POINTS,
        (End::Arrived | End::TimedOut, true) => lifting,
        (End::Refused, true) => WRONG_REFUSAL_POINTS + lifting,
        (End::Refused, false) => {
            VERDICT_POINTS
                + (TIME_POINTS + LOW_FORCE_POINTS)
                    * share(1.0 - (outcome.time_s - 1.0) / DELAY_MAX_S)
        }
        (End::TimedOut, false) => LEFT_STANDING_POINTS,
        (End::Arrived, false) => WRONG_REFUSAL_POINTS,
    }
}

/// Returns whether the evaluation counts the outcome as a success.
#[must_use]
pub fn succeeds(object: &Object, outcome: &Outcome) -> bool {
    verdict(outcome)
        == if object.is_feasible() {
            Verdict::Held
        } else {
            Verdict::Refused
        }
}

/// Verdict on an object, common to both simulations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Lifted and in the hand, with little slip.
    Held,
    /// Refused, unharmed.
    Refused,
    /// Crushed.
    Crushed,
    /// Any other outcome: left behind, lost, slipped, too late.
    Failed,
}

/// Returns the verdict of the reduced simulation.
#[must_use]
pub fn verdict(outcome: &Outcome) -> Verdict {
    let [_, raised_m] = outcome.raised_m;
    let [_, slid_m] = outcome.slip_m;
    match outcome.end {
        End::Crushed => Verdict::Crushed,
        End::Refused => Verdict::Refused,
        End::Arrived if raised_m >= LIFTED_SHARE * LIFT_M && slid_m <= SLIP_MAX_M => Verdict::Held,
        End::Arrived | End::Lost | End::TimedOut => Verdict::Failed,
    }
}

/// Returns the verdict of the full simulation from its outcome name.
#[must_use]
pub fn full_verdict(outcome: &str) -> Verdict {
    match outcome {
        "held" => Verdict::Held,
        "crushed" => Verdict::Crushed,
        refused if refused.starts_with("refused") => Verdict::Refused,
        _ => Verdict::Failed,
    }
}
