//! Tests of the object history.

use super::*;
use crate::body::{Motion, rotated};

const TICK_NS: u64 = 1_000_000;

fn object(name: &str) -> WorldObject {
    let object = Object::built_in(name).expect("built in");
    WorldObject::new(&Placed::new(object, [0.3, 0.0], 0.0), &Ground::default())
}

/// Puts an object at rest at a height with a tilt.
fn pose(object: &mut WorldObject, up_m: f64, lean_rad: f64) {
    let mut orientation = [1.0, 0.0, 0.0, 0.0];
    for _ in 0..100 {
        orientation = rotated(orientation, &Vector3::new(lean_rad / 100.0, 0.0, 0.0));
    }
    object.body.set_motion(&Motion {
        position_m: Vector3::new(0.3, 0.0, up_m + object.start_m.z),
        orientation,
        velocity_m_s: Vector3::zeros(),
        angular_rad_s: Vector3::zeros(),
    });
}

#[test]
fn open_bottle_spills_above_thirty_degrees() {
    let check = |lean_deg: f64, open: bool, spilt: u32, tipped: u32| {
        let mut bottle = object("open-bottle");
        pose(&mut bottle, 0.05, lean_deg.to_radians());
        bottle.touched = true;
        bottle.evaluate(&Ground::default(), false, open, TICK_NS);
        let truth = bottle.truth(None);
        assert_eq!((truth.spilt, truth.tipped), (spilt, tipped), "{lean_deg}°");
    };
    check(20.0, true, 0, 0);
    check(35.0, true, 1, 0);
    check(35.0, false, 0, 0);
    check(50.0, true, 1, 1);
}

/// Returns the truth of a wooden block after ticks of height, fingertip contact and support force.
fn truth_after(history: &[(f64, bool, f64)]) -> ObjectTruth {
    let mut wood = object("wood");
    for (tick, (up_m, held, table_n)) in (1..).zip(history) {
        pose(&mut wood, *up_m, 0.0);
        (wood.touched, wood.body.table_n) = (*held, *table_n);
        wood.evaluate(&Ground::default(), false, false, tick * TICK_NS);
    }
    wood.truth(None)
}

#[test]
fn first_release_after_landing_counts() {
    let history = [
        (0.010, true, 0.0),
        (0.010, true, 0.0),
        (0.0, true, 0.1),
        (0.0, true, 3.0),
        (0.0, true, 0.1),
        (0.0, true, 3.0),
        (0.0, false, 3.0),
        (0.0, true, 3.0),
        (0.0, false, 3.0),
    ];
    let truth = truth_after(&history);
    assert_eq!(
        [truth.landed_ns, truth.carried_ns, truth.released_ns],
        [3, 6, 7].map(|tick| tick * TICK_NS)
    );
    assert_eq!((truth.released_above_m, truth.dropped), (0.0, 0));
}

/// Regression: after put back and regrasp, the first landing counted, which made the release 17 s
/// late.
#[test]
fn second_lift_resets_the_landing() {
    let history = [
        (0.010, true, 0.0),
        (0.0, true, 3.0),
        (0.0, true, 3.0),
        (0.0, false, 3.0),
        (0.0, true, 3.0),
        (0.010, true, 0.0),
        (0.0, true, 3.0),
        (0.0, true, 3.0),
        (0.0, false, 3.0),
    ];
    let output = |history| {
        let truth = truth_after(history);
        [truth.landed_ns, truth.carried_ns, truth.released_ns].map(|ns| ns / TICK_NS)
    };
    assert_eq!(output(&history[..5]), [2, 2, 4]);
    assert_eq!(output(&history[..6]), [0, 0, 0], "lifted again");
    assert_eq!(output(&history), [7, 7, 9]);
}

#[test]
fn release_in_the_air_is_a_drop() {
    let mut wood = object("wood");
    for (tick, held) in (1..).zip([true, false]) {
        pose(&mut wood, 0.010, 0.0);
        wood.touched = held;
        wood.evaluate(&Ground::default(), false, false, tick * TICK_NS);
    }
    let truth = wood.truth(None);
    assert_eq!((truth.dropped, truth.landed_ns), (1, 0));
    assert_eq!(truth.released_ns, 2 * TICK_NS);
    assert!((truth.released_above_m - 0.010).abs() < 1e-4, "{truth:?}");
}

#[test]
fn object_stands_only_upright_free_and_in_place() {
    let check = |off_m: f64, lean_rad: f64, pressed: bool, share: f64, stands: u32| {
        let mut wood = object("wood");
        pose(&mut wood, 0.0, lean_rad);
        wood.body.position_m.x += off_m;
        wood.body.table_n = share * wood.body.weight_n();
        wood.touched = pressed;
        wood.evaluate(&Ground::default(), false, false, TICK_NS);
        let truth = wood.truth(None);
        assert!((truth.displaced_m - off_m).abs() < 1e-12);
        let case = format!("{off_m} m, {lean_rad} rad, pressed {pressed}, carried {share}");
        assert_eq!(truth.stands, stands, "{case}");
    };
    check(0.0, 0.0, false, 1.0, 1);
    check(0.006, 0.02, false, 0.95, 1);
    check(0.012, 0.0, false, 1.0, 0);
    check(0.0, 0.2, false, 1.0, 0);
    check(0.0, 0.0, true, 1.0, 0);
    check(0.0, 0.0, false, 0.5, 0);
}

/// Regression: the impact of a bottle that fell flat out of opening fingertips counted as 1.1 N of
/// the hand.
#[test]
fn only_the_hands_own_force_presses_the_object_down() {
    let pressed_down_n = |table_n: f64, hand_up_n: f64| {
        let mut wood = object("wood");
        pose(&mut wood, 0.010, 0.0);
        wood.touched = true;
        wood.evaluate(&Ground::default(), false, false, TICK_NS);
        pose(&mut wood, 0.0, 0.0);
        for tick in 2..200 {
            wood.record_contact(1.0, hand_up_n);
            wood.body.table_n = table_n;
            wood.evaluate(&Ground::default(), false, false, tick * TICK_NS);
        }
        wood.truth(None).pressed_down_n
    };
    let weight_n = object("wood").body.weight_n();
    assert_eq!(pressed_down_n(weight_n + 5.0, 0.0), 0.0);
    assert_eq!(pressed_down_n(weight_n, 2.0), 0.0);
    assert!((pressed_down_n(weight_n + 2.0, -2.0) - 2.0).abs() < 1e-6);
}
