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
