//! Grip verification: remembers the force ratio F_t/F_n at which lift verification succeeded
//! (design choice, not in the paper).
//!
//! The force pattern alone can indicate false slip: misaligned faces shear all elements uniformly,
//! and more so at higher grip force. While no side exceeds the verified ratio, pattern-based slip
//! triggers no pressing, warning or rejection. Dropping is detected by weight ([`crate::modules`],
//! Module 2, cause (e)) and is never suppressed.

use crate::filter::low_pass;
use crate::limits::NORMAL_MIN_N;
use crate::perception::Percept;

/// Filter time constant of F_t/F_n, s (design choice: suppresses frame noise).
const FILTER_S: f64 = 0.03;
/// Permitted multiple of the verified F_t/F_n (design choice: covers hand tremor).
const MARGIN: f64 = 1.05;

/// Verification state of one grip, from first touch.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct GripVerification {
    /// Filtered F_t/F_n of the grasp side where it is largest.
    force_ratio: f64,
    /// Value of that ratio at the verification.
    verified_ratio: Option<f64>,
    /// Time since the ratio exceeded the limit, s; infinite without verification.
    unverified_s: f64,
}

impl Default for GripVerification {
    fn default() -> Self {
        Self {
            force_ratio: 0.0,
            verified_ratio: None,
            unverified_s: f64::INFINITY,
        }
    }
}

impl GripVerification {
    /// Updates the ratio from one tick.
    pub(super) fn update(&mut self, percept: &Percept) {
        let fingers = percept.sides.iter();
        let used = fingers
            .map(|finger| finger.tangential_n / finger.normal_n.max(NORMAL_MIN_N))
            .fold(0.0, |most: f64, used| if used > most { used } else { most });
        self.force_ratio = low_pass(self.force_ratio, used, percept.step_s, FILTER_S);
        self.unverified_s = if self.is_verified() {
            0.0
        } else {
            self.unverified_s + percept.step_s
        };
    }

    /// Marks the object as suspended at the present ratio.
    pub(super) fn set_verified(&mut self) {
        self.verified_ratio = Some(self.force_ratio);
    }

    /// Returns true while the ratio is within the verified limit.
    pub(super) fn is_verified(&self) -> bool {
        self.verified_ratio
            .is_some_and(|proved| self.force_ratio <= MARGIN * proved)
    }

    /// Time since the grip was last within the verified limit, s; infinite without verification.
    pub(super) fn unverified_s(&self) -> f64 {
        self.unverified_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::perception::ContactPercept;

    /// Verifies a 1 N load per side at grip force `from_n` and returns the unverified time after
    /// one second at `then_n`.
    fn unverified_s(from_n: f64, then_n: f64) -> f64 {
        let mut proof = GripVerification::default();
        let hold = |proof: &mut GripVerification, normal_n| {
            let finger = ContactPercept {
                normal_n,
                tangential_n: 1.0,
                ..ContactPercept::default()
            };
            for _ in 0..1000 {
                proof.update(&Percept {
                    sides: [finger; 2],
                    step_s: 1e-3,
                    ..Percept::default()
                });
            }
        };
        hold(&mut proof, from_n);
        assert!(!proof.is_verified(), "not verified yet");
        assert_eq!(proof.unverified_s(), f64::INFINITY, "not verified yet");
        proof.set_verified();
        assert!(proof.is_verified());
        hold(&mut proof, then_n);
        proof.unverified_s()
    }

    #[test]
    fn verification_lapses_when_the_grip_weakens() {
        assert_eq!(unverified_s(3.0, 3.0), 0.0);
        assert_eq!(unverified_s(3.0, 5.0), 0.0, "higher grip force");
        assert_eq!(unverified_s(3.0, 2.9), 0.0, "tremor");
        assert!(
            (0.9..1.0).contains(&unverified_s(3.0, 2.5)),
            "lower grip force"
        );
    }
}
