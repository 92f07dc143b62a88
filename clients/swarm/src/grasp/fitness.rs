//! What a grasp is worth, in the paper's manner: an accuracy part, an efficiency part, and a guard against accidents.
//!
//! Per object at most 100, as per goal of the field: E₁ = 60 for what should become of it, held or refused, as the evaluation's
//! judge has it; E₂ = 20 for time and 20 for gentleness, which only what was judged well twice earns: when the hand arrived and
//! again after it had to hold for a second, sliding no further between. What fails earns a little for how far it came, so that
//! the roulette has something to choose from.

use pinch::{End, HOLD_S, LIFT_M, Object, Outcome};

/// Accuracy, and the two halves of efficiency.
const HELD: f32 = 60.0;
const IN_TIME: f32 = 20.0;
const GENTLE: f32 = 20.0;
/// What an accident earns: held at the end, but not at both judgements or sliding.
const ACCIDENT: f32 = 30.0;
/// What is left of it when an object that could be held is refused, or one that could not is left standing.
const TIMID: f32 = 5.0;
const UNHARMED: f32 = 20.0;
/// What lifting part of the way earns at most.
const LIFTING: f32 = 10.0;
/// Share of the lift that counts as lifted; farthest slip in the hand, m (the evaluation's judge).
const LIFTED_SHARE: f32 = 0.5;
const SLIP_MAX_M: f32 = 0.003;
/// Farthest slip between the judgements, m.
const CREEP_MAX_M: f32 = 0.001;
/// Time of a lift that is never slowed, and how much more earns nothing, s. Refusing may take as long as the slack.
const LIFT_S: f32 = 4.0 + HOLD_S;
const SLOWER_S: f32 = 3.0;

/// Points of one grasp, 0 to 100.
#[must_use]
pub fn points(object: &Object, outcome: &Outcome) -> f32 {
    let kept = |judgement: usize| {
        outcome.raised_m[judgement] >= LIFTED_SHARE * LIFT_M
            && outcome.slid_m[judgement] <= SLIP_MAX_M
    };
    let share = |value: f32| value.clamp(0.0, 1.0);
    let lifting = LIFTING * share(outcome.raised_m[1] / LIFT_M);
    match (outcome.end, object.is_feasible()) {
        (End::Crushed | End::Lost, _) => 0.0,
        (End::Arrived, true) if kept(0) && kept(1) => {
            if outcome.slid_m[1] - outcome.slid_m[0] > CREEP_MAX_M {
                return ACCIDENT;
            }
            let late_s = outcome.time_s - LIFT_S;
            let in_time = IN_TIME * share(1.0 - late_s / SLOWER_S);
            HELD + in_time + GENTLE * share(object.needed_n() / outcome.normal_n)
        }
        (End::Arrived, true) if kept(1) => ACCIDENT,
        (End::Arrived | End::Late, true) => lifting,
        (End::Refused, true) => TIMID + lifting,
        (End::Refused, false) => {
            HELD + (IN_TIME + GENTLE) * share(1.0 - (outcome.time_s - 1.0) / SLOWER_S)
        }
        (End::Late, false) => UNHARMED,
        (End::Arrived, false) => TIMID,
    }
}

/// Whether the judge of the evaluation would call it a success.
#[must_use]
pub fn succeeds(object: &Object, outcome: &Outcome) -> bool {
    verdict(outcome)
        == if object.is_feasible() {
            Verdict::Held
        } else {
            Verdict::Refused
        }
}

/// What became of an object, in words that both simulations know.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Lifted and in the hand, hardly slid.
    Held,
    /// Given up, unharmed.
    Refused,
    /// Crushed.
    Crushed,
    /// None of these: left behind, lost, slid, too late.
    Failed,
}

/// The verdict of the reduced simulation.
#[must_use]
pub fn verdict(outcome: &Outcome) -> Verdict {
    let [_, raised_m] = outcome.raised_m;
    let [_, slid_m] = outcome.slid_m;
    match outcome.end {
        End::Crushed => Verdict::Crushed,
        End::Refused => Verdict::Refused,
        End::Arrived if raised_m >= LIFTED_SHARE * LIFT_M && slid_m <= SLIP_MAX_M => Verdict::Held,
        End::Arrived | End::Lost | End::Late => Verdict::Failed,
    }
}

/// The verdict of the full simulation, by the outcome that its judge names.
#[must_use]
pub fn full_verdict(outcome: &str) -> Verdict {
    match outcome {
        "held" => Verdict::Held,
        "crushed" => Verdict::Crushed,
        refused if refused.starts_with("refused") => Verdict::Refused,
        _ => Verdict::Failed,
    }
}
