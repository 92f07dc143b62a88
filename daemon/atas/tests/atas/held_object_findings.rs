//! Held object: findings about drift, drop, rotation and loss.

use crate::held_object::{LIFTS, Rig, holding, with_step};
use atas_core::held_object::{LiftFinding, StepFacts};
use atas_core::perception::Percept;
use robot_model::{GraspSide, Skin};
use shm_schemas::{Cause, Hand, Reason};

/// Load of 2 N with a moment, N·m, about the closing axis, and a torsion ratio.
fn twisted(moment_n_m: f64, torsion: f64) -> Percept {
    let mut measured = holding(4.0, 2.0);
    measured.sides[GraspSide::First].moment_n_m = moment_n_m;
    measured.sides[GraspSide::First].torsion = torsion;
    measured
}

#[test]
fn untouched_object_has_no_findings() {
    for rig in [Rig::new(), Rig::gripped()] {
        let of = &rig.estimator;
        assert_eq!(of.unheld_s(), f64::INFINITY);
        assert_eq!(
            (of.drop_s(), of.overload_m(), of.lever_m()),
            (0.0, 0.0, 0.0)
        );
        assert!(!of.has_lost_contact() && !of.lever_is_known());
        let warning = of.drift_warning(Hand::LEFT);
        let reasons = [of.loss(), of.turning(), of.failure(), warning];
        assert_eq!(reasons, [None; 4]);
    }
}

#[test]
fn drift_is_measured_against_the_opening() {
    let mut rig = Rig::verified();
    let compression = Skin::DOME_41.compression;
    let closed_m = 0.001;
    for half_m in rig.pose.half_opening_m.iter_mut() {
        *half_m -= closed_m / 2.0;
    }
    let object = rig.hold(1, 4.0, 2.0);
    let object_m_n = rig.settings.grasp.compression_m / object.thresholds.f2_n;
    let verified_n = object.grip.expect("verified").verified_normal_n.mean();
    let skin_m_n = compression.compliance_m_n(verified_n);
    let expected_n = closed_m / (2.0 * 4.0 * skin_m_n + object_m_n);
    assert!(
        (object.drift.force_n + expected_n).abs() < 1e-6,
        "{:?}",
        object.drift
    );
}

#[test]
fn drift_is_warned_of_after_half_a_second_of_a_grip() {
    let warned = |is_gripped: bool| {
        let mut rig = Rig::verified();
        if !is_gripped {
            rig.estimator.let_go();
        }
        let drifted = with_step(0.25, holding(9.0, 2.0));
        [(); 3].map(|()| {
            rig.update(&drifted, LIFTS);
            rig.estimator.drift_warning(Hand::RIGHT)
        })
    };
    assert_eq!(warned(false), [None; 3]);
    let [first, second, third] = warned(true);
    assert_eq!((first, second), (None, None));
    let Some(Reason::ForceAgainstOpening {
        hand,
        force_n,
        lift_force_n,
    }) = third
    else {
        panic!("{third:?}")
    };
    assert_eq!(hand, Hand::RIGHT);
    assert!(
        (force_n - 9.0).abs() < 0.01 && (lift_force_n - 4.0).abs() < 0.01,
        "{force_n}, {lift_force_n}"
    );
}

#[test]
fn duration_of_a_drop_counts_after_the_verification() {
    let dropped_s = |rig: &mut Rig| {
        rig.hold(1000, 4.0, 2.0);
        assert_eq!(rig.estimator.drop_s(), 0.0, "no drop");
        let drops = rig.hold(50, 4.0, 1.8).drops;
        (drops, rig.estimator.drop_s())
    };
    let (drops, drop_s) = dropped_s(&mut Rig::verified());
    assert!(drops && (0.001..0.06).contains(&drop_s), "{drop_s} s");
    let mut minimised = Rig::gripped();
    minimised.pose.centre_m.z += 0.002;
    minimised
        .estimator
        .receive(LiftFinding::MinimisesGrip, true);
    assert_eq!(dropped_s(&mut minimised), (true, 0.0));
}

#[test]
fn overload_slides_the_object() {
    let mut rig = Rig::verified();
    rig.hold(20, 4.0, 6.0);
    let slide_m = rig.estimator.overload_m();
    assert!((1e-5..0.01).contains(&slide_m), "{slide_m} m");
}

/// Lever after 100 ms with a moment.
fn lever_m(rig: &mut Rig, step: StepFacts) -> f64 {
    for _ in 0..100 {
        rig.update(&twisted(0.01, 0.7), step);
    }
    rig.estimator.lever_m()
}

#[test]
fn lever_is_estimated_while_a_monitored_object_is_carried() {
    let unmonitored = StepFacts {
        is_monitored: false,
        ..LIFTS
    };
    let lever = lever_m(&mut Rig::raised(), LIFTS);
    assert!((0.003..0.005).contains(&lever), "{lever} m");
    let mut let_go = Rig::raised();
    let_go.estimator.let_go();
    for (case, rig, step) in [
        ("not monitored", &mut Rig::raised(), unmonitored),
        ("not raised", &mut Rig::gripped(), LIFTS),
        ("not gripped", &mut let_go, LIFTS),
        ("found", &mut Rig::found(), LIFTS),
    ] {
        assert_eq!(lever_m(rig, step), 0.0, "{case}");
    }
}

#[test]
fn rotation_in_the_hand_is_a_failure() {
    let mut rig = Rig::verified();
    assert!(lever_m(&mut rig, LIFTS) > 0.0);
    assert!(!rig.estimator.lever_is_known() && rig.estimator.turning().is_none());
    assert_eq!(rig.estimator.failure(), None);
    for _ in 0..600 {
        rig.update(&twisted(0.001, 0.7), LIFTS);
    }
    assert!(rig.estimator.lever_is_known());
    let causes = [rig.estimator.turning(), rig.estimator.failure()].map(|r| r.map(|r| r.cause()));
    assert_eq!(causes, [Some(Cause::TURNED_IN_HAND); 2]);
    rig.estimator.restart_in_hand();
    let found = (
        rig.estimator.lever_m(),
        rig.estimator.turning(),
        rig.estimator.failure(),
    );
    assert_eq!(found, (0.0, None, None), "other motion resembles it");
    lever_m(&mut rig, LIFTS);
    rig.estimator.keep_if_touched();
    assert_eq!(rig.estimator.lever_m(), 0.0);
}

#[test]
fn frames_without_duration_change_nothing() {
    let mut rig = Rig::verified();
    rig.update(&with_step(0.0, holding(4.0, 9.0)), LIFTS);
    rig.hold(300, 4.0, 2.0);
    assert_eq!(rig.estimator.failure(), None, "9 N are no weight");
}

#[test]
fn verified_object_without_load_is_lost() {
    let lost = |rig: &mut Rig| {
        rig.hold(500, 4.0, 2.0);
        assert_eq!(rig.estimator.loss(), None);
        rig.hold(500, 4.0, 0.0);
        rig.estimator.loss().map(|reason| reason.cause())
    };
    let mut rig = Rig::verified();
    assert_eq!(lost(&mut rig), Some(Cause::LOST_OBJECT));
    assert!(rig.estimator.failure().is_some());
    rig.estimator.let_go();
    assert_eq!(rig.estimator.loss(), None, "it was let go");
    assert_eq!(lost(&mut Rig::raised()), None, "not verified");
}

#[test]
fn standing_object_has_slipped_in_a_monitored_step() {
    let slipped = |mut rig: Rig, is_monitored: bool| {
        rig.update(&holding(4.0, 2.0), LIFTS);
        rig.estimator.receive(LiftFinding::Standing, is_monitored);
        rig.estimator.failure().map(|reason| reason.cause())
    };
    assert_eq!(slipped(Rig::raised(), true), Some(Cause::SLIPPED_IN_HAND));
    assert_eq!(slipped(Rig::raised(), false), None, "not monitored");
    let mut let_go = Rig::raised();
    let_go.estimator.let_go();
    assert_eq!(slipped(let_go, true), None, "not gripped");
    assert_eq!(slipped(Rig::found(), true), None, "found");
}
