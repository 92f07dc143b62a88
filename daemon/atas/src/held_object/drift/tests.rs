//! Tests of the drift of the grip force.

use super::*;
use robot_model::Skin;

/// Returns drift, report and bound for a grip verified at 1 N per side.
fn estimate(closed_mm: f64, normal_n: [f64; 2]) -> (f64, bool, bool) {
    let grip = verified_at([1.0; 2], normal_n, closed_mm);
    let drift = Drift::estimate(&grip, &Skin::DOME_41.compression, 0.0, false);
    (drift.force_n, drift.is_reported, drift.stops_closing)
}

#[test]
fn force_outside_the_bounds_of_the_opening_is_drift() {
    // Skin compliance at 1 N: 0.44 mm · 0.48 = 0.211 mm/N.
    for (closed_mm, normal_n, drift_n, is_reported, stops_closing) in [
        (0.0, 1.0, 0.0, false, false),
        (0.0, 1.3, 0.3, false, false),
        (0.0, 1.5, 0.5, true, false),
        (0.0, 0.5, -0.5, true, false),
        (0.42, 1.25, 0.0, false, false),
        (0.42, 1.9, 0.0, false, false),
        (0.42, 3.0, 1.006, true, false),
        (2.0, 1.0, -1.184, true, true),
        (-0.42, 0.5, 0.0, false, false),
        (-0.42, 1.5, 0.749, true, false),
    ] {
        let (found_n, reports, stops) = estimate(closed_mm, [normal_n; 2]);
        assert!(
            (found_n - drift_n).abs() < 2e-3,
            "{closed_mm} mm, {normal_n} N: {found_n} N"
        );
        assert_eq!(
            (reports, stops),
            (is_reported, stops_closing),
            "{closed_mm} mm, {normal_n} N"
        );
    }
}

#[test]
fn load_along_the_closing_axis_is_no_drift() {
    for normal_n in [[2.0, 0.1], [0.4, 3.0], [1.0, 2.0]] {
        assert_eq!(estimate(0.0, normal_n), (0.0, false, false), "{normal_n:?}");
    }
}

/// Skin that yields 0.25 mm/N at 1 N.
const SKIN: Compression = Compression {
    at_1n_m: 0.000_5,
    exponent: 0.5,
};

/// Grip verified at this force per side, N.
fn verified_at(verified_n: [f64; 2], normal_n: [f64; 2], closed_mm: f64) -> VerifiedGrip {
    VerifiedGrip {
        load_n: 0.5,
        held_n: 0.5,
        mean_n: 0.5,
        scatter_n: 0.0,
        normal_n: normal_n.into(),
        verified_normal_n: verified_n.into(),
        closed_m: closed_mm * 1e-3,
    }
}

/// Returns the drift of a grip verified at 1 N per side that has not moved since.
fn drift(normal_n: [f64; 2], lowers: bool) -> Drift {
    Drift::estimate(&verified_at([1.0; 2], normal_n, 0.0), &SKIN, 0.0, lowers)
}

fn flags(found: Drift) -> [bool; 3] {
    [found.is_reported, found.is_excessive, found.stops_closing]
}

#[test]
fn soft_object_allows_a_smaller_change_of_force() {
    // Closing by 1 mm adds at most 2 N, and at least 1 mm over finger, skin and object.
    for (object_mm_n, least_n) in [(0.0, 0.5), (2.0, 0.25), (8.0, 0.1)] {
        let drift_n = |normal_n| {
            let grip = verified_at([1.0; 2], [normal_n; 2], 1.0);
            Drift::estimate(&grip, &SKIN, object_mm_n * 1e-3, false).force_n
        };
        let found_n = drift_n(0.9);
        assert!(
            (found_n + 0.1 + least_n).abs() < 1e-12,
            "{object_mm_n} mm/N: {found_n} N"
        );
        assert_eq!(drift_n(1.0 + least_n + 1e-9), 0.0, "{object_mm_n} mm/N");
    }
}

/// In the air nothing adds force; a support does.
#[test]
fn excess_counts_at_once_in_the_air_and_beyond_the_support_when_lowered() {
    // Excess in the air and while lowered, N.
    for (normal_n, in_air_n, lowered_n) in [
        (0.2, 0.0, 0.0),
        (1.0, 0.0, 0.0),
        (1.01, 0.01, 0.0),
        (1.15, 0.15, 0.0),
        (1.19, 0.19, 0.0),
        (1.21, 0.21, 0.21),
        (1.5, 0.5, 0.5),
    ] {
        for (lowers, excess_n) in [(false, in_air_n), (true, lowered_n)] {
            let found_n = drift([normal_n; 2], lowers).excess_n();
            assert!(
                (found_n - excess_n).abs() < 1e-9,
                "{normal_n} N, lowered {lowers}: {found_n} N"
            );
        }
    }
}

#[test]
fn each_limit_must_be_exceeded_on_both_sides() {
    // Forces per side; drift, N; while lowered: reported, excessive, closing stops.
    for (normal_n, force_n, expected) in [
        ([1.45, 1.15], 0.15, [false, false, false]),
        ([1.15, 1.45], 0.15, [false, false, false]),
        ([1.45, 1.25], 0.25, [false, true, false]),
        ([1.5, 1.3], 0.3, [false, true, false]),
        ([1.5, 1.41], 0.41, [true, true, false]),
        ([-0.15, 0.5], -0.5, [true, false, false]),
        ([0.5, -0.15], -0.5, [true, false, false]),
        ([-0.2, -0.15], -1.15, [true, false, true]),
        ([-0.09, -0.2], -1.09, [true, false, false]),
    ] {
        let [reported, excessive, stops] = expected;
        for (lowers, is_excessive) in [(true, excessive), (false, force_n > 0.0)] {
            let found = drift(normal_n, lowers);
            assert!(
                (found.force_n - force_n).abs() < 1e-12,
                "{normal_n:?}: {found:?}"
            );
            let expected = [reported, is_excessive, stops];
            assert_eq!(flags(found), expected, "{normal_n:?}, {lowers}");
        }
    }
}

/// The limits grow with the verified force.
#[test]
fn limits_scale_with_the_verified_force() {
    for (force_n, expected) in [
        (0.45, [false, true, false]),
        (0.35, [false, true, false]),
        (0.29, [false, false, false]),
        (0.69, [false, true, false]),
        (0.71, [true, true, false]),
        (-2.05, [true, false, false]),
        (-2.15, [true, false, true]),
    ] {
        let found = flags(Drift::of_side(force_n, 2.0, true));
        assert_eq!(found, expected, "{force_n} N");
    }
    for (verified_n, share) in [(0.171_875, 0.3), (0.171_875, 0.1), (0.125, -1.0)] {
        let limit_n = share * verified_n + 0.1 * f64::signum(share);
        let found = flags(Drift::of_side(limit_n, verified_n, true));
        let expected = [share < 0.0, share == 0.3, false];
        assert_eq!(found, expected, "the limit itself, {share}");
    }
    let found = flags(Drift::of_side(0.0, 2.0, false));
    assert_eq!(found, [false; 3], "no force beyond the opening");
}

#[test]
fn side_without_verified_force_has_no_drift() {
    for verified_n in [[0.0; 2], [0.0, 1.0], [1.0, 0.0]] {
        let grip = verified_at(verified_n, [2.0; 2], 0.0);
        let found = Drift::estimate(&grip, &SKIN, 0.0, false);
        assert_eq!(found, Drift::default(), "{verified_n:?}");
    }
}
