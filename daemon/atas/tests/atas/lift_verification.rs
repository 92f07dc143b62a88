//! Lift verification: during the pull-back a suspended object keeps its load, a standing one loses
//! it.

use crate::bench::{Bench, with_utilisation};
use atas_core::held_object::LiftFinding;
use atas_core::modules::{Proposal, Verdict};
use atas_core::perception::Percept;
use robot_model::GraspSide;
use shm_schemas::{ModuleId, Reason};

/// Normal forces well below and above F_2 = 4 N.
const BELOW_F2_N: f64 = 2.0;
const ABOVE_F2_N: f64 = 4.1;

/// Vertical load of the object, N.
const LOAD_N: f64 = 1.0;
/// Frames in the mean load before and after the pull-back.
const FRAMES: usize = 5;

/// Percept of an object that loads both fingertips together with `load_n`, N.
fn weighing(normal_n: f64, load_n: f64) -> Percept {
    let mut measured = with_utilisation(normal_n, 0.8);
    for finger in &mut measured.fingertips[..2] {
        finger.force_tip_n.z = -0.5 * load_n;
    }
    measured
}

/// Lifts to the pull-back, moves back far enough with this share of the load; returns the resulting
/// proposal. A negative share: the object stands, and the fingertips push it down.
fn pulled_back(bench: &mut Bench, normal_n: f64, load_share: f64) -> Proposal {
    let measured = weighing(normal_n, LOAD_N);
    assert_eq!(bench.evaluate(&measured).carry_ceiling, 1.0);
    bench.object.carried_m = 0.0021;
    let waits = bench.evaluate(&measured);
    assert_eq!((waits.active, waits.carry_ceiling), (true, 0.0), "waits");
    let pulls = bench.evaluate_for(FRAMES, &measured);
    assert_eq!(
        (pulls.active, pulls.carry_ceiling),
        (true, -1.0),
        "pulls back"
    );
    let unloaded = weighing(normal_n, load_share * LOAD_N);
    bench.object.carried_m = 0.0018;
    let pulls = bench.evaluate(&unloaded);
    assert_eq!(pulls.carry_ceiling, -1.0, "not far enough");
    bench.object.carried_m = 0.0016;
    let waits = bench.evaluate(&unloaded);
    assert_eq!(waits.carry_ceiling, 0.0, "waits for frames");
    let waits = bench.evaluate_for(FRAMES - 1, &unloaded);
    assert_eq!(waits.verdict, Verdict::None);
    bench.evaluate(&unloaded)
}

/// Lifts on to grip minimisation.
fn minimises_grip(bench: &mut Bench, measured: &Percept) {
    bench.object.carried_m = 0.0027;
    let trial = bench.evaluate(measured);
    assert_eq!((trial.active, trial.carry_ceiling), (true, 0.0), "waits");
    assert_eq!(trial.finding, LiftFinding::MinimisesGrip);
}

#[test]
fn suspended_object_is_verified_after_grip_minimisation() {
    for (normal_n, share) in [(BELOW_F2_N, 1.0), (BELOW_F2_N, 0.7), (ABOVE_F2_N, 0.7)] {
        let mut bench = Bench::new(ModuleId::LIFT_VERIFICATION);
        let measured = weighing(normal_n, LOAD_N);
        let end = pulled_back(&mut bench, normal_n, share);
        assert_eq!(
            (end.active, end.verdict),
            (false, Verdict::None),
            "{normal_n} N"
        );
        minimises_grip(&mut bench, &measured);
        bench.closing_m_s = [-0.001; 2].into();
        assert_eq!(
            bench.evaluate_for(1000, &measured).finding,
            LiftFinding::MinimisesGrip,
            "waits for the fingers"
        );
        bench.closing_m_s = [0.0; 2].into();
        let pulls = bench.evaluate_for(302 + FRAMES, &measured);
        assert_eq!(pulls.carry_ceiling, -1.0, "pulls back");
        bench.object.carried_m = 0.0022;
        let end = bench.evaluate_for(FRAMES + 1, &measured);
        assert_eq!((end.finding, end.active), (LiftFinding::Suspended, false));
        bench.object.carried_m = 0.03;
        assert!(
            !bench.evaluate(&measured).active,
            "two verifications suffice"
        );
    }
}

/// Regression: the shake of the pull-back started a slide at the limit of friction, which kinetic
/// friction did not stop.
#[test]
fn minimised_grip_is_secured_before_the_pull_back() {
    for (utilisation, factor) in [(0.8, 1.0), (0.95, 0.95 / 0.84)] {
        let mut bench = Bench::new(ModuleId::LIFT_VERIFICATION);
        let measured = |normal_n| {
            let mut measured = with_utilisation(normal_n, utilisation);
            for finger in &mut measured.fingertips[..2] {
                finger.force_tip_n.z = -0.5 * LOAD_N;
            }
            measured
        };
        pulled_back(&mut bench, BELOW_F2_N, 1.0);
        minimises_grip(&mut bench, &measured(BELOW_F2_N));
        bench.evaluate_for(302, &measured(BELOW_F2_N));
        let pulls_back = |bench: &mut Bench, normal_n| {
            let proposal = bench.evaluate_for(FRAMES + 2, &measured(normal_n));
            assert_eq!(
                proposal.closing_m_s[GraspSide::First] > 0.0,
                proposal.carry_ceiling == 0.0
            );
            proposal.carry_ceiling == -1.0
        };
        if factor > 1.0 {
            assert!(
                !pulls_back(&mut bench, 0.99 * factor * BELOW_F2_N),
                "closes"
            );
        }
        assert!(
            pulls_back(&mut bench, 1.01 * factor * BELOW_F2_N),
            "S = {utilisation}"
        );
    }
}

/// Regression: with 5 % crosstalk an object slid unnoticed out of a grip with seemingly low
/// friction utilisation.
#[test]
fn dropping_object_is_gripped_harder() {
    let mut bench = Bench::new(ModuleId::LIFT_VERIFICATION);
    pulled_back(&mut bench, BELOW_F2_N, 1.0);
    minimises_grip(&mut bench, &weighing(BELOW_F2_N, 1.0));
    bench.closing_m_s = [-0.001; 2].into();
    let steady = bench.evaluate_for(1000, &weighing(BELOW_F2_N, 1.0));
    assert_eq!(steady.finding, LiftFinding::MinimisesGrip);
    bench.object.drops = true;
    let fallen = bench.evaluate(&weighing(BELOW_F2_N, 0.8));
    assert_eq!(fallen.finding, LiftFinding::Standing);
    bench.object.drops = false;
    let presses = bench.evaluate(&weighing(BELOW_F2_N, 0.8));
    assert!(presses.closing_m_s[GraspSide::First] > 0.0 && presses.carry_ceiling == 0.0);
}

#[test]
fn standing_object_at_f2_is_refused() {
    for share in [-0.8, 0.0, 0.5] {
        let end = pulled_back(
            &mut Bench::new(ModuleId::LIFT_VERIFICATION),
            ABOVE_F2_N,
            share,
        );
        let too_soft = Reason::TooSoft {
            force_n: ABOVE_F2_N,
            limit_n: 4.0,
            module: ModuleId::LIFT_VERIFICATION,
        };
        let case = format!("with {share} of its load");
        assert_eq!(end.verdict, Verdict::Refuse(too_soft), "{case}");
    }
}

/// Regression: an object that slid evenly through the fingers below F_2 was reported as held.
#[test]
fn standing_object_below_f2_is_pressed_and_retried() {
    let mut bench = Bench::new(ModuleId::LIFT_VERIFICATION);
    let end = pulled_back(&mut bench, BELOW_F2_N, 0.2);
    assert_eq!(
        (end.active, end.verdict, end.carry_ceiling),
        (true, Verdict::None, 0.0)
    );
    let press = |bench: &mut Bench, normal_n| bench.evaluate(&with_utilisation(normal_n, 0.8));
    assert!(press(&mut bench, 1.1 * BELOW_F2_N).closing_m_s[GraspSide::First] > 0.0);
    let again = press(&mut bench, 1.25 * BELOW_F2_N);
    assert_eq!(
        (again.active, again.closing_m_s, again.carry_ceiling),
        (false, [0.0; 2].into(), 1.0)
    );
    bench.object.carried_m += 0.0009;
    assert!(
        !press(&mut bench, 1.25 * BELOW_F2_N).active,
        "half the travel"
    );
    bench.object.carried_m += 0.0002;
    let pulls = bench.evaluate_for(FRAMES + 1, &weighing(1.25 * BELOW_F2_N, LOAD_N));
    assert_eq!(pulls.carry_ceiling, -1.0);
}

/// Regression: single frames of a 100 Hz sensor misjudged light objects.
#[test]
fn noise_of_single_frames_is_averaged() {
    let mut bench = Bench::new(ModuleId::LIFT_VERIFICATION);
    let frame = |load_n| weighing(BELOW_F2_N, load_n);
    bench.evaluate(&frame(LOAD_N));
    bench.object.carried_m = 0.0021;
    bench.evaluate(&frame(LOAD_N));
    for load_n in [1.8, 1.0, 0.2, 1.0, 1.0] {
        bench.evaluate(&frame(load_n));
    }
    bench.object.carried_m = 0.0016;
    bench.evaluate(&frame(LOAD_N));
    for load_n in [0.2, 1.0, 1.8, 1.0, 1.0] {
        bench.evaluate(&frame(load_n));
    }
    let end = bench.evaluate(&frame(LOAD_N));
    assert_ne!(end.finding, LiftFinding::Standing, "{end:?}");
}

/// A slow sensor must deliver new frames first.
#[test]
fn pull_back_waits_for_frames() {
    let mut bench = Bench::new(ModuleId::LIFT_VERIFICATION);
    let mut measured = weighing(BELOW_F2_N, LOAD_N);
    bench.evaluate(&measured);
    bench.object.carried_m = 0.0021;
    bench.evaluate_for(FRAMES + 1, &measured);
    bench.object.carried_m = 0.0016;
    measured.step_s = 0.0;
    assert_eq!(bench.evaluate_for(100, &measured).carry_ceiling, 0.0);
    measured.step_s = 0.033;
    assert_eq!(bench.evaluate_for(FRAMES - 1, &measured).carry_ceiling, 0.0);
    let end = bench.evaluate(&measured);
    assert_eq!(end.carry_ceiling, 1.0, "suspended");
}

/// A slow sensor delays the response to a slip, so the hand lifts more slowly.
#[test]
fn lifting_speed_follows_the_frame_rate() {
    for (delay_s, ceiling) in [(0.001, 1.0), (0.005, 1.0), (0.015, 0.5), (0.035, 0.25)] {
        let mut bench = Bench::new(ModuleId::LIFT_VERIFICATION);
        let mut measured = weighing(BELOW_F2_N, LOAD_N);
        measured.delay_s = delay_s;
        let lifts = bench.evaluate(&measured);
        assert!((lifts.carry_ceiling - ceiling).abs() < 1e-9, "{delay_s} s");
    }
}
