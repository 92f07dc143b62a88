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
mod tests;
