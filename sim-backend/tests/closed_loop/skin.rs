//! Corrupted skins (fault catalogue F15 to F17): nothing is dropped or crushed.

use std::cell::RefCell;

use crate::rig::{Rig, goal, object};
use robot_model::HandSide;
use shm_schemas::{Cause, GoalKind, HandFrame, Mode};
use sim_backend::random::trial_seed;
use sim_backend::{DriftModel, Scene};

/// Ticks from the fault to the evaluation: longer than the goal of a hold.
const WATCHED: u64 = 20_000;

/// Corrupts the skin of a hand while it lifts an object. `lie` receives the time since the start,
/// s, and the frame.
fn lift_with_corrupted_skin(name: &str, lie: impl Fn(f64, &mut HandFrame) + 'static) -> Rig {
    let scene = Scene::grasp(object(name), HandSide::Right);
    let mut rig = Rig::new(&scene);
    let request = goal(GoalKind::GRASP, &scene, HandSide::Right);
    rig.execute_until(&request, "lift", 0.02);
    assert_eq!(rig.warnings, []);
    rig.corrupt_skin(HandSide::Right, lie);
    rig.ticks(WATCHED);
    rig
}

fn drifting(n_per_s: f64, fingers: core::ops::Range<usize>) -> impl Fn(f64, &mut HandFrame) {
    move |lied_s, frame| {
        for element in frame.force_n[fingers.clone()].as_flattened_mut() {
            element[0] += (n_per_s * lied_s) as f32;
        }
    }
}

/// Regression: a zero drift of 0.01 N/s per element opened the hand, and the goal succeeded with
/// the object on the table.
#[test]
fn zero_drift_drops_no_object() {
    let check = |name: &str, n_per_s: f64, fingers: core::ops::Range<usize>| {
        let case = format!("{name}, {n_per_s} N/s, fingertips {fingers:?}");
        let rig = lift_with_corrupted_skin(name, drifting(n_per_s, fingers));
        let object = rig.object();
        assert_eq!(
            (object.dropped, object.crushed),
            (0, 0),
            "{case}: {object:?}"
        );
        assert!(
            object.slip_in_hand_m < 0.003,
            "{case}: slipped {} m",
            object.slip_in_hand_m
        );
        assert!(object.lifted_m > 0.015, "{case}: {object:?}");
        // A falling zero removes elements from the contact, which only raises the grip slightly. A
        // slow rise is not detected within this time.
        if n_per_s >= 0.01 {
            let found = (rig.mode(), rig.reason().cause());
            assert_eq!(found, (Mode::HOLD, Cause::FORCE_AGAINST_JOINTS), "{case}");
        }
    };
    for name in ["wood", "slippery-200", "slippery-50", "bottle", "paper-box"] {
        check(name, 0.01, 0..2);
        check(name, 0.003, 0..2);
        check(name, 0.01, 0..1);
        check(name, -0.01, 0..2);
    }
}

/// Regression: a zero that falls from the start hides the touch. The controller took the squeeze of
/// the fingers for their free torque, and crushed soft objects without a warning.
#[test]
fn zero_drift_from_the_start_harms_no_object() {
    for name in ["paper-box", "sponge", "wood"] {
        for n_per_s in [-0.01, -0.003, 0.003, 0.01] {
            let scene = Scene::grasp(object(name), HandSide::Right);
            let mut rig = Rig::new(&scene);
            rig.corrupt_skin(HandSide::Right, drifting(n_per_s, 0..2));
            rig.begin(&goal(GoalKind::GRASP, &scene, HandSide::Right));
            rig.ticks(2 * WATCHED);
            let object = rig.object();
            let case = format!("{name}, {n_per_s} N/s: {:?}, {object:?}", rig.reason());
            assert_eq!((object.dropped, object.crushed), (0, 0), "{case}");
        }
    }
}

/// Regression: without joint torques, a drift in the grip was noticed by nothing. A rising zero
/// opened the hand until the object fell, a falling one closed it until the object was crushed.
#[test]
fn zero_drift_without_torques_harms_no_object() {
    for name in ["paper-box", "sponge", "slippery-50"] {
        for n_per_s in [-0.003, 0.003] {
            let scene = Scene::grasp(object(name), HandSide::Right);
            let mut rig = Rig::new(&scene);
            rig.is_torque_missing = true;
            rig.execute_successfully(&goal(GoalKind::GRASP, &scene, HandSide::Right));
            rig.corrupt_skin(HandSide::Right, drifting(n_per_s, 0..2));
            rig.ticks(WATCHED);
            let object = rig.object();
            let case = format!("{name}, {n_per_s} N/s: {:?}, {object:?}", rig.warnings);
            assert_eq!((object.dropped, object.crushed), (0, 0), "{case}");
            assert!(object.lifted_m > 0.01, "{case}");
            assert!(
                rig.warnings.contains(&Cause::FORCE_AGAINST_OPENING),
                "{case}"
            );
        }
    }
}

/// Regression: the grip closed by the force that a falling zero hid, until a paper box was crushed.
/// A rising zero opened the grip of a bottle, which needs nearly F_2, to F_2 by its reading.
#[test]
fn zero_drift_from_the_start_without_torques_harms_no_object() {
    for (name, number, rate_n_s) in [("paper-box", 1002, -0.05), ("bottle", 1007, 0.05)] {
        let seed = trial_seed(name, number);
        let mut scene = Scene::grasp(object(name), HandSide::Right).varied(seed);
        scene.sensor_model.drift = Some(DriftModel {
            rate_n_s: [rate_n_s, 0.0, 0.0],
            limit_n: 3.0,
            from_s: 0.0,
        });
        let mut rig = Rig::seeded(&scene, seed);
        rig.is_torque_missing = true;
        rig.begin(&goal(GoalKind::GRASP, &scene, HandSide::Right));
        rig.ticks(3 * WATCHED);
        let object = rig.object();
        let case = format!("{name}, {rate_n_s} N/s: {:?}, {object:?}", rig.warnings);
        assert_eq!((object.dropped, object.crushed), (0, 0), "{case}");
        assert!(object.lifted_m > 0.01, "{case}");
    }
}

/// Freezes the most loaded elements of the first fingertip.
fn sticking(count: usize) -> impl Fn(f64, &mut HandFrame) {
    let kept = RefCell::new(Vec::new());
    move |_, frame| {
        let readings_n = &mut frame.force_n[0];
        let mut kept = kept.borrow_mut();
        if kept.is_empty() {
            let mut pressed: Vec<usize> = (0..readings_n.len()).collect();
            pressed.sort_by(|a, b| readings_n[*b][0].total_cmp(&readings_n[*a][0]));
            kept.extend(pressed[..count].iter().map(|&at| (at, readings_n[at])));
        }
        for (element, reading_n) in kept.iter() {
            readings_n[*element] = *reading_n;
        }
    }
}

#[test]
fn stuck_element_is_reported_once_and_ignored() {
    for name in ["wood", "slippery-50", "bottle"] {
        let rig = lift_with_corrupted_skin(name, sticking(1));
        assert_eq!(rig.warnings, [Cause::ELEMENT_STUCK], "{name}");
        assert_eq!(rig.mode(), Mode::RUN, "{name}");
        let object = rig.object();
        assert_eq!(
            (object.dropped, object.crushed),
            (0, 0),
            "{name}: {object:?}"
        );
    }
}

#[test]
fn too_many_stuck_elements_cause_hold() {
    let rig = lift_with_corrupted_skin("wood", sticking(4));
    let output = [Cause::ELEMENTS_INVALID, Cause::FORCE_AGAINST_JOINTS];
    assert!(output.contains(&rig.reason().cause()), "{:?}", rig.reason());
    let object = rig.object();
    assert_eq!((object.dropped, object.crushed), (0, 0), "{object:?}");
}
