//! Drift of the tactile zero in a held grip: compares the change of the measured grip force since
//! the lift verification with the change that the opening of the hand allows.
//!
//! Closing by x compresses two skins and the object, and bends both fingers. A skin gives way by
//! d(F) = a·F^p, so its compliance at the verified force F_v is c = a·p·F_v^(p−1). With the
//! compliance b of the object, the force changes by ΔF with
//!
//! ```text
//! x / (2·s·c + b) ≤ ΔF ≤ x / (2·c)        (closing; exchanged for opening)
//! ```
//!
//! s is the compliance of finger and skin relative to the skin. F_2 compresses the object by
//! `grasp.compression_m`, so b is at most `grasp.compression_m` / F_2. A measured change outside
//! these bounds on both sides is drift: the zero of the sensors has moved.

use super::VerifiedGrip;
use robot_model::Compression;

/// Compliance of finger and skin relative to the skin (design choice: a simulated finger bends
/// three times as far as its skin).
const FINGER_COMPLIANCE: f64 = 4.0;
/// Drift that is reported: share of the verified force, and minimum in N (design choice: three
/// times creep and hysteresis of 5 %).
const REPORTED_SHARE: f64 = 0.3;
const REPORTED_MIN_N: f64 = 0.1;
/// Excess that does not count for F_2 while the object is set down: share of the verified force,
/// and minimum in N (design choice: a support that pushes a heavy block up adds a tenth).
const EXCESSIVE_SHARE: f64 = 0.1;
const EXCESSIVE_MIN_N: f64 = 0.1;
/// Missing force beyond which the grip no longer closes: share of the verified force, and minimum
/// in N (design choice: the true force has about doubled).
const BOUND_SHARE: f64 = 1.0;
const BOUND_MIN_N: f64 = 0.1;

/// Drift of the grip force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Drift {
    /// Measured force beyond the bounds of the opening, N per side; negative if it is missing.
    pub force_n: f64,
    /// The drift is beyond creep and hysteresis.
    pub is_reported: bool,
    /// The measured force is beyond what a support adds at the same opening. In the air nothing
    /// does: fingers that do not close crush nothing.
    is_excessive: bool,
    /// The true force may be twice the verified one; further closing may crush the object.
    pub stops_closing: bool,
}

impl Drift {
    /// Returns the force that only the drift reports, N. Opening in response would drop the object.
    #[must_use]
    pub fn excess_n(&self) -> f64 {
        if self.is_excessive { self.force_n } else { 0.0 }
    }

    /// Returns the force that only the drift reports, N, once it is beyond creep and hysteresis;
    /// negative if the drift hides force.
    pub(super) fn reported_n(&self) -> f64 {
        if self.is_reported { self.force_n } else { 0.0 }
    }

    /// Estimates the drift of a verified grip; `object_m_n` is the compliance of the object, m/N.
    /// `lowers`: the hand sets the object down.
    pub(super) fn estimate(
        grip: &VerifiedGrip,
        skin: &Compression,
        object_m_n: f64,
        lowers: bool,
    ) -> Self {
        let sides = grip.normal_n.iter().zip(&grip.verified_normal_n);
        let sides = sides.map(|(normal_n, verified_n)| {
            if *verified_n <= 0.0 {
                return Self::default();
            }
            let force_n =
                force_beyond_opening_n((*normal_n, *verified_n), grip.closed_m, skin, object_m_n);
            Self::of_side(force_n, *verified_n, lowers)
        });
        sides.reduce(Self::agreed).unwrap_or_default()
    }

    fn of_side(force_n: f64, verified_n: f64, lowers: bool) -> Self {
        let by_support_n = if lowers {
            EXCESSIVE_SHARE * verified_n + EXCESSIVE_MIN_N
        } else {
            0.0
        };
        Self {
            force_n,
            is_reported: force_n.abs() > REPORTED_SHARE * verified_n + REPORTED_MIN_N,
            is_excessive: force_n > by_support_n,
            stops_closing: -force_n > BOUND_SHARE * verified_n + BOUND_MIN_N,
        }
    }

    /// Returns the drift that both sides show. A load along the closing axis changes the forces of
    /// the sides in opposite directions.
    fn agreed(one: Self, other: Self) -> Self {
        if one.force_n * other.force_n <= 0.0 {
            return Self::default();
        }
        let smaller = if one.force_n.abs() < other.force_n.abs() {
            one
        } else {
            other
        };
        Self {
            force_n: smaller.force_n,
            is_reported: one.is_reported && other.is_reported,
            is_excessive: one.is_excessive && other.is_excessive,
            stops_closing: one.stops_closing && other.stops_closing,
        }
    }
}

/// Returns the part of the force change since the verification that the opening does not allow, N.
fn force_beyond_opening_n(
    (normal_n, verified_n): (f64, f64),
    closed_m: f64,
    skin: &Compression,
    object_m_n: f64,
) -> f64 {
    let skin_m_n = skin.compliance_m_n(verified_n);
    let small_n = closed_m / (2.0 * FINGER_COMPLIANCE * skin_m_n + object_m_n);
    let large_n = closed_m / (2.0 * skin_m_n);
    let change_n = normal_n - verified_n;
    change_n - change_n.max(small_n.min(large_n)).min(small_n.max(large_n))
}

#[cfg(test)]
mod tests {
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
}
