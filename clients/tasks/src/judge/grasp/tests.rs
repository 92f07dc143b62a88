use shm_schemas::Reason;

use super::*;

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
        reason: Reason::new(cause),
        ..GoalUpdate::default()
    }
}

#[test]
fn outcomes_follow_ground_truth() {
    let check = |state, cause, truth: WorldTruth, expected: Outcome| {
        assert_eq!(
            Outcome::evaluate(&end(state, cause), &truth, 1, LIFT_M),
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
    let in_hand = |slip_m, turn_deg: f64| {
        let mut truth = truth(0.039, 5.0);
        truth.objects[0].slip_in_hand_m = slip_m;
        truth.objects[0].turn_in_hand_rad = turn_deg.to_radians();
        truth
    };
    check(done, none, in_hand(0.0029, 9.9), Outcome::Held);
    check(done, none, in_hand(0.0031, 0.0), Outcome::Slipped);
    check(done, none, in_hand(0.0, 10.1), Outcome::Turned);
    check(done, none, in_hand(f64::NAN, 0.0), Outcome::Slipped);
    check(done, none, in_hand(0.0, f64::NAN), Outcome::Turned);
    let heavy = Cause::TOO_HEAVY;
    let standing = |mut truth: WorldTruth| {
        truth.objects[0].stands = 1;
        truth
    };
    let (refused, put_back) = (GoalState::REFUSED, standing(truth(0.0, 0.0)));
    check(refused, heavy, put_back, Outcome::Refused(heavy));
    check(refused, heavy, truth(0.0, 0.0), Outcome::Displaced(heavy));
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
fn failures_have_their_keys() {
    let check = |outcome: Outcome, step, expected| assert_eq!(outcome.key(step), expected);
    check(Outcome::Crushed, "lift", "crushed");
    let heavy = Cause::TOO_HEAVY;
    check(Outcome::Refused(heavy), "leave", "refused: too-heavy");
    check(Outcome::Displaced(heavy), "leave", "displaced: too-heavy");
    check(Outcome::Turned, "hold", "turned in the hand");
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
fn only_held_and_refused_can_be_expected() {
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
        Outcome::Displaced(heavy),
        Outcome::Slipped,
        Outcome::Turned,
        Outcome::Failed(heavy),
    ] {
        check(outcome, true, false);
        check(outcome, false, false);
    }
}
