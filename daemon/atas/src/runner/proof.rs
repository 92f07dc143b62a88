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
const FELT_S: f64 = 0.03;
/// Permitted multiple of the verified F_t/F_n (design choice: covers hand tremor).
const MARGIN: f64 = 1.05;

/// Verification state of one grip, from first touch.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Proof {
    /// Filtered F_t/F_n of the grasp side where it is largest.
    used: f64,
    /// Value of that ratio at the verification.
    proved: Option<f64>,
    /// Time since the ratio exceeded the limit, s; infinite without verification.
    lapsed_s: f64,
}

impl Default for Proof {
    fn default() -> Self {
        Self {
            used: 0.0,
            proved: None,
            lapsed_s: f64::INFINITY,
        }
    }
}

impl Proof {
    /// Updates the ratio from one tick.
    pub(super) fn follow(&mut self, percept: &Percept) {
        let fingers = percept.virtual_fingers.iter();
        let used = fingers
            .map(|finger| finger.tangential_n / finger.normal_n.max(NORMAL_MIN_N))
            .fold(0.0, |most: f64, used| if used > most { used } else { most });
        self.used = low_pass(self.used, used, percept.step_s, FELT_S);
        self.lapsed_s = if self.stands() {
            0.0
        } else {
            self.lapsed_s + percept.step_s
        };
    }

    /// Marks the object as suspended at the present ratio.
    pub(super) fn prove(&mut self) {
        self.proved = Some(self.used);
    }

    /// Returns true while the ratio is within the verified limit.
    pub(super) fn stands(&self) -> bool {
        self.proved
            .is_some_and(|proved| self.used <= MARGIN * proved)
    }

    /// Time since the grip was last within the verified limit, s; infinite without verification.
    pub(super) fn lapsed_s(&self) -> f64 {
        self.lapsed_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::perception::FingerPercept;

    /// Verifies a 1 N load per side at grip force `from_n` and returns the unverified time after
    /// one second at `then_n`.
    fn lapsed_s(from_n: f64, then_n: f64) -> f64 {
        let mut proof = Proof::default();
        let hold = |proof: &mut Proof, normal_n| {
            let finger = FingerPercept {
                normal_n,
                tangential_n: 1.0,
                ..FingerPercept::default()
            };
            for _ in 0..1000 {
                proof.follow(&Percept {
                    virtual_fingers: [finger; 2],
                    step_s: 1e-3,
                    ..Percept::default()
                });
            }
        };
        hold(&mut proof, from_n);
        assert!(!proof.stands(), "nothing is proved yet");
        assert_eq!(proof.lapsed_s(), f64::INFINITY, "nothing is proved yet");
        proof.prove();
        assert!(proof.stands());
        hold(&mut proof, then_n);
        proof.lapsed_s()
    }

    #[test]
    fn a_proof_stands_while_the_grip_is_as_firm() {
        assert_eq!(lapsed_s(3.0, 3.0), 0.0);
        assert_eq!(lapsed_s(3.0, 5.0), 0.0, "firmer");
        assert_eq!(lapsed_s(3.0, 2.9), 0.0, "it trembles");
        assert!((0.9..1.0).contains(&lapsed_s(3.0, 2.5)), "gentler");
    }
}
