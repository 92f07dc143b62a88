use robot_model::{HandSide, RobotModel};
use shm_schemas::ReasonRecord;

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
        reason: ReasonRecord {
            cause,
            ..ReasonRecord::default()
        },
        ..GoalUpdate::default()
    }
}

#[test]
fn outcomes_follow_ground_truth() {
    let robot = RobotModel::two_hand_arm().expect("built-in robot");
    let hand = robot.hand(HandSide::Right);
    let check = |state, cause, truth: WorldTruth, expected: Outcome| {
        assert_eq!(
            Outcome::evaluate(&end(state, cause), &truth, hand, LIFT_M),
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

/// Regression: the judge looked at the first two fingertips only, both on side 1 of this hand.
#[test]
fn object_without_thumb_contact_is_not_held() {
    let robot = RobotModel::find("three-finger").expect("built-in robot");
    let check = |normal_n: [f64; 4], expected: Outcome| {
        let mut truth = truth(0.039, 0.0);
        truth.normal_n[1] = normal_n;
        let done = end(GoalState::SUCCEEDED, Cause::NONE);
        let outcome = Outcome::evaluate(&done, &truth, robot.hand(HandSide::Right), LIFT_M);
        assert_eq!(outcome, expected, "{normal_n:?}");
    };
    check([1.0, 1.0, 2.0, 0.0], Outcome::Held);
    check([2.0, 0.0, 2.0, 0.0], Outcome::Held);
    check([1.0, 1.0, 0.0, 0.0], Outcome::NotLifted);
    check([0.0, 0.0, 2.0, 0.0], Outcome::NotLifted);
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
