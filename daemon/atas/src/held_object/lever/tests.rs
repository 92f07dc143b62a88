//! Tests of the lever arm.

use super::*;
use crate::perception::ContactPercept;

/// Frames of 1 ms with these moments, N·m, tangential forces, N, and torsion ratios. Without
/// grip force, any vertical load counts.
fn frame(moments_n_m: [f64; 2], tangential_n: [f64; 2], torsion: [f64; 2]) -> Percept {
    let side = |side: usize| ContactPercept {
        moment_n_m: moments_n_m[side],
        tangential_n: tangential_n[side],
        torsion: torsion[side],
        ..ContactPercept::default()
    };
    Percept {
        sides: [side(0), side(1)].into(),
        step_s: 1e-3,
        ..Percept::default()
    }
}

fn lever_after(ticks: usize, percept: &Percept) -> Lever {
    let mut lever = Lever::default();
    for _ in 0..ticks {
        lever.update(percept, percept.total_tangential_n());
    }
    lever
}

/// Regression: a block gripped by misaligned fingertips was put back four times and grasped
/// ever farther from its centre, because the moment of the standing block counted as its lever.
#[test]
fn moment_of_a_standing_object_is_no_lever() {
    let mut percept = frame([0.002, -0.002], [0.4; 2], [0.0; 2]);
    for side in percept.sides.iter_mut() {
        side.normal_n = 4.0;
    }
    for (down_n, lever_m) in [(0.1, 0.0), (0.8, 0.005)] {
        let mut lever = Lever::default();
        for _ in 0..1000 {
            lever.update(&percept, down_n);
        }
        let found_m = lever.max_m();
        assert!((found_m - lever_m).abs() < 1e-4, "{down_n} N: {found_m} m");
    }
}

#[test]
fn lever_needs_a_vertical_load_in_proportion_to_the_grip() {
    // Grip force per side, and vertical load, N.
    for (normal_n, down_n, counts) in [
        (4.0, 0.24, true),
        (4.0, 0.24_f64.next_down(), false),
        (2.0, 0.12, true),
        (2.0, 0.12_f64.next_down(), false),
        (4.0, 0.0, false),
        (4.0, -2.0, false),
        (0.0, 0.0, true),
    ] {
        let mut percept = frame([0.01, 0.0], [1.0; 2], [0.7; 2]);
        for side in percept.sides.iter_mut() {
            side.normal_n = normal_n;
        }
        let mut lever = Lever::default();
        lever.update(&percept, down_n);
        let found = (lever.max_m() > 0.0, lever.torsion_max > 0.0);
        assert_eq!(found, (counts, counts), "{down_n} N at {normal_n} N");
    }
}

#[test]
fn lever_approaches_moment_over_load() {
    for (moments_n_m, tangential_n, lever_m, filter_s) in [
        ([0.01, -0.002], [1.0, 1.0], 0.006, 0.0575),
        ([-0.01, 0.002], [1.0, 1.0], -0.006, 0.0575),
        ([0.003, 0.001], [0.1, 0.2], 0.02 / 3.0, 0.1),
        ([0.001, 0.0], [0.025, 0.025], 0.02, 0.35),
        ([0.001, 0.0], [0.025, 0.024], 0.0, 0.35),
    ] {
        let lever = lever_after(30, &frame(moments_n_m, tangential_n, [0.3, 0.4]));
        let share = 1.0 - (filter_s / (filter_s + 1e-3_f64)).powi(30);
        let expected_m = lever_m * share;
        assert!((lever.max_m() - expected_m).abs() < 1e-12, "{lever:?}");
        let torsion = if lever_m == 0.0 { 0.0 } else { 0.4 * share };
        assert!((lever.torsion_max - torsion).abs() < 1e-12, "{lever:?}");
        assert!(!lever.has_peaked() && lever.turning().is_none());
    }
}

#[test]
fn lever_has_peaked_once_it_shrinks_for_the_filter_time() {
    let (large, none) = ([0.01, 0.0], [0.0; 2]);
    let mut lever = lever_after(100, &frame(large, [1.0; 2], [0.0; 2]));
    let max_m = lever.max_m();
    let shrinks = Percept {
        step_s: 0.025,
        ..frame(none, [1.0; 2], [0.0; 2])
    };
    // The first frame shrinks the lever, and counts.
    for has_peaked in [false, false, true] {
        lever.update(&shrinks, 2.0);
        assert_eq!((lever.has_peaked(), lever.max_m()), (has_peaked, max_m));
    }
    let centred = lever_after(200, &frame(none, [1.0; 2], [0.0; 2]));
    assert!(!centred.has_peaked(), "no lever, no maximum");
}

#[test]
fn object_has_rotated_with_torsion_and_smaller_lever() {
    // Remaining share of a lever of 0.5 m.
    for (torsion_max, remaining, has_rotated) in [
        (0.7, 0.8, true),
        (0.7, 0.9, false),
        (0.6, 0.8, false),
        (0.6, 0.6, true),
        (0.6, 0.7, false),
        (0.55, 0.8, false),
        (0.55, 0.6, true),
        (0.5, 0.1, false),
        (0.5_f64.next_up(), 0.1, true),
    ] {
        let lever = Lever {
            torsion_max,
            now_m: remaining / 2.0,
            max_m: 0.5,
            ..Lever::default()
        };
        let reason = Reason::TurnedInHand {
            lever_m: remaining / 2.0,
            lever_before_m: 0.5,
        };
        let expected = has_rotated.then_some(reason);
        assert_eq!(lever.rotation(), expected, "{torsion_max}, {remaining}");
    }
}

#[test]
fn object_turns_after_a_rotation_longer_than_a_swing() {
    let mut lever = Lever {
        torsion_max: 0.7,
        now_m: 0.5,
        max_m: 1.0,
        ..Lever::default()
    };
    let still = Percept {
        step_s: 0.15,
        ..frame([0.0; 2], [1.0; 2], [0.0; 2])
    };
    for turns in [false, false, true] {
        lever.update(&still, 2.0);
        assert_eq!(lever.turning().is_some(), turns, "{lever:?}");
    }
    let reason = Reason::TurnedInHand {
        lever_m: lever.now_m,
        lever_before_m: 1.0,
    };
    assert_eq!(lever.turning(), Some(reason));
}
