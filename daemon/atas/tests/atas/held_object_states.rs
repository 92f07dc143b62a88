//! Held object: states that the task executor reads.

use crate::bench::{fingertip, percept};
use crate::held_object::{LIFTS, Rig, holding, with_step};
use atas_core::held_object::{LiftFinding, StepFacts};
use atas_core::perception::{ContactPercept, StiffnessFit};
use atas_core::thresholds::{ForceLimitSource, Thresholds};
use nalgebra::Vector3;

const SEARCHES: StepFacts = StepFacts {
    searches: true,
    ..LIFTS
};
const FIT: StiffnessFit = StiffnessFit {
    object_n_m: 10_000.0,
    confidence: 1.0,
    new_contact: false,
};

/// States: gripped, held, found, verified, carried, touched.
fn states(rig: &Rig) -> [bool; 6] {
    let of = &rig.estimator;
    [
        of.is_gripped(),
        of.is_held(),
        of.is_found(),
        of.is_verified(),
        of.is_carried(),
        of.object().all_touched,
    ]
}

#[test]
fn states_follow_the_grasp() {
    let mut rig = Rig::new();
    assert_eq!(states(&rig), [false; 6], "before the touch");
    rig.estimator.lift(rig.pose.centre_m);
    assert_eq!(states(&rig), [false; 6], "an empty hand carries nothing");
    let mut rig = Rig::new();
    rig.update(&holding(2.0, 0.0), SEARCHES);
    assert_eq!(
        states(&rig),
        [false, false, false, false, false, true],
        "touched"
    );
    let thresholds = rig.estimator.thresholds();
    rig.estimator.set_stiffness(FIT, thresholds);
    assert_eq!(
        states(&rig),
        [true, true, false, false, false, true],
        "gripped"
    );
    rig.estimator.lift(rig.pose.centre_m);
    assert_eq!(
        states(&rig),
        [true, true, false, false, true, true],
        "lifted"
    );
    rig.estimator.receive(LiftFinding::Suspended, true);
    assert_eq!(
        states(&rig),
        [true, true, false, true, true, true],
        "verified"
    );
    rig.estimator.let_go();
    assert_eq!(
        states(&rig),
        [false, false, false, true, false, true],
        "let go"
    );
    let mut rig = Rig::found();
    rig.update(&holding(2.0, 0.0), LIFTS);
    assert_eq!(states(&rig), [true, true, true, false, true, true], "found");
}

#[test]
fn contact_is_lost_after_a_bounce() {
    let one_side = percept([fingertip(2.0), ContactPercept::default()]);
    let [apart, touching] = [one_side, holding(2.0, 0.0)].map(|p| with_step(0.025, p));
    let mut rig = Rig::gripped();
    for lost in [false, false, true, true] {
        rig.update(&apart, LIFTS);
        assert_eq!(rig.estimator.has_lost_contact(), lost);
        assert_eq!(
            (rig.estimator.is_held(), rig.estimator.is_gripped()),
            (!lost, true)
        );
    }
    rig.estimator.begin_search();
    assert!(
        rig.estimator.has_lost_contact(),
        "another search does not touch"
    );
    let mut kept = Rig::gripped();
    kept.update(&touching, LIFTS);
    for (rig, is_kept) in [(&mut rig, false), (&mut kept, true)] {
        rig.estimator.keep_if_touched();
        assert_eq!(rig.estimator.is_gripped(), is_kept);
    }
    rig.update(&touching, LIFTS);
    assert!(!rig.estimator.has_lost_contact());
    rig.estimator.keep_if_touched();
    assert!(!rig.estimator.is_gripped(), "a touch alone is no grip");
}

#[test]
fn closing_counts_from_the_first_touch_of_a_search() {
    let mut rig = Rig::new();
    let mut closing = |gap_m: f64, normal_n: f64, step: StepFacts| {
        rig.gap_m = gap_m;
        let object = rig.update(&holding(normal_n, 0.0), step);
        (object.all_touched, object.closing_m)
    };
    assert_eq!(closing(0.06, 2.0, LIFTS), (false, 0.0), "no search");
    assert_eq!(closing(0.055, 0.0, SEARCHES), (false, 0.0), "no touch");
    assert_eq!(closing(0.05, 2.0, SEARCHES), (true, 0.0));
    let (touched, closed_m) = closing(0.047, 2.0, SEARCHES);
    assert!(touched && (closed_m - 0.003).abs() < 1e-12, "{closed_m} m");
    let (touched, closed_m) = closing(0.052, 0.0, LIFTS);
    assert!(touched && (closed_m + 0.002).abs() < 1e-12, "{closed_m} m");
}

#[test]
fn search_keeps_what_is_known_of_a_found_object() {
    let mut rig = Rig::found();
    let object = rig.update(&holding(2.0, 0.0), LIFTS);
    assert!((object.carried_m - 0.01).abs() < 1e-12 && object.all_touched);
    assert!(
        (object.closing_m + 0.05).abs() < 1e-12,
        "its first touch is unknown"
    );
    assert_eq!(rig.estimator.unheld_s(), 0.0, "it was held before");
    rig.estimator.begin_search();
    assert!(rig.estimator.is_gripped() && rig.estimator.is_found());
    assert_eq!(rig.estimator.unheld_s(), f64::INFINITY);
    let mut probed = Rig::gripped();
    let unknown = Thresholds::for_unknown_object(&probed.settings.grasp);
    assert_eq!(probed.estimator.stiffness(), Some(FIT));
    probed.estimator.reset_probe(unknown);
    assert_eq!(probed.estimator.stiffness(), None);
    assert_eq!(probed.estimator.thresholds(), unknown);
}

#[test]
fn carried_object_is_gripped_with_the_smaller_minimum() {
    for (f1_n, is_carried, expected_n) in [
        (0.5, false, 0.5),
        (0.5, true, 0.2),
        (0.1, true, 0.1),
        (0.1, false, 0.1),
    ] {
        let mut rig = Rig::gripped();
        rig.settings.grasp.carry_min_n = 0.2;
        let thresholds = Thresholds {
            f1_n,
            f2_n: 4.0,
            source: ForceLimitSource::Object,
        };
        rig.estimator.set_stiffness(FIT, thresholds);
        if !is_carried {
            rig.estimator.let_go();
        }
        let min_force_n = rig.update(&holding(2.0, 0.0), LIFTS).min_force_n;
        assert_eq!(
            min_force_n, expected_n,
            "F_1 {f1_n} N, carried {is_carried}"
        );
    }
}

#[test]
fn object_is_carried_freely_above_its_support() {
    let released = StepFacts {
        verifies_lift: false,
        ..LIFTS
    };
    let lowers = StepFacts {
        lowers: true,
        ..released
    };
    for (height_m, step, suspended, freely) in [
        (0.0, released, true, false),
        (0.001, released, true, false),
        (0.0011, released, true, true),
        (0.01, LIFTS, false, false),
        (0.01, lowers, true, false),
    ] {
        let mut rig = Rig::gripped();
        rig.pose.centre_m = Vector3::zeros();
        rig.estimator.lift(rig.pose.centre_m);
        rig.pose.centre_m.z = height_m;
        let object = rig.update(&holding(2.0, 1.0), step);
        assert!((object.carried_m - height_m).abs() < 1e-12);
        let found = (object.suspended, object.carried_freely);
        assert_eq!(found, (suspended, freely), "{height_m} m, {step:?}");
    }
    let mut rig = Rig::verified();
    let object = rig.hold(1, 4.0, 2.0);
    assert!(object.suspended && object.carried_freely, "verified");
}

#[test]
fn load_swings_after_a_change_of_speed() {
    let mut rig = Rig::verified();
    rig.hold(1000, 4.0, 2.0);
    let slow = with_step(0.075, holding(4.0, 2.0));
    for (carry_scale, swings) in [
        (1.0, false),
        (0.5, true),
        (0.5, true),
        (0.5, false),
        (1.0, true),
    ] {
        rig.carry_scale = carry_scale;
        assert_eq!(rig.update(&slow, LIFTS).swings, swings, "{carry_scale}");
    }
    let mut standing = Rig::gripped();
    assert!(!standing.update(&slow, LIFTS).swings, "it stands");
    standing.carry_scale = 0.5;
    standing.estimator.receive(LiftFinding::MinimisesGrip, true);
    assert!(standing.update(&slow, LIFTS).swings, "grip minimisation");
}

#[test]
fn closing_counts_as_response_only_during_the_lift() {
    let released = StepFacts {
        verifies_lift: false,
        ..LIFTS
    };
    for (height_m, step, is_held) in [
        (0.0, LIFTS, false),
        (0.0005, LIFTS, true),
        (0.0005, released, false),
    ] {
        let mut rig = Rig::gripped();
        rig.pose.centre_m.z += height_m;
        rig.update(&holding(2.0, 0.5), step);
        let presses = (0..200).map(|_| rig.update(&holding(4.0, 0.5), step).load_is_held);
        assert_eq!(presses.last(), Some(is_held), "{height_m} m, {step:?}");
    }
}

#[test]
fn load_is_the_net_force_across_the_closing_axis() {
    let side = |across_n: f64| ContactPercept {
        force_tip_n: Vector3::new(3.0, across_n, -1.0),
        ..fingertip(4.0)
    };
    let mut rig = Rig::verified();
    let pushed = with_step(1e3, percept([side(0.5), side(1.0)]));
    let grip = rig.update(&pushed, LIFTS).grip.expect("verified");
    assert!((grip.load_n - 2.5).abs() < 1e-3, "{} N", grip.load_n);
}

#[test]
fn only_a_minimised_grip_is_shown_to_hold_by_a_lift() {
    let mut rig = Rig::gripped();
    rig.hold(100, 4.0, 2.0);
    rig.estimator.receive(LiftFinding::None, true);
    assert!(!rig.hold(1, 4.0, 2.0).load_is_held);
}

#[test]
fn grip_is_verified_once() {
    let mut rig = Rig::verified();
    rig.hold(300, 5.0, 2.0);
    rig.estimator.receive(LiftFinding::Suspended, true);
    let grip = rig.hold(1, 5.0, 2.0).grip.expect("verified");
    let near = |n: f64| (n - 4.0).abs() < 0.01;
    assert!(grip.verified_normal_n.iter().all(|n| near(*n)), "{grip:?}");
}
