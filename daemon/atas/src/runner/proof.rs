//! The grip that the load test has proved, and whether the hand still grips as firmly (ours, not in the paper).
//!
//! The pattern of forces alone may say that a patch slides which does not: faces that stand askew by a few degrees shear every
//! element of a fingertip alike, and the more the harder they are pressed, so pressing is no cure. What has been tugged at and
//! hung is better evidence. While no finger bears more tangential force for its normal force than it did then, what the
//! pattern says is no cause to press, to warn or to refuse. What falls is told by its weight ([`crate::modules`]: Module 2,
//! cause (e)), and a proof does not speak against that.

use crate::filter::low_pass;
use crate::limits::NORMAL_MIN_N;
use crate::perception::Percept;

/// Time constant over which F_t/F_n is felt, s (ours: the noise of single frames).
const FELT_S: f64 = 0.03;
/// Multiple of the proved F_t/F_n up to which a grip counts as firm as that (ours: what a trembling hand makes of it).
const MARGIN: f64 = 1.05;

/// What a load test has proved of one grip, from its first touch on.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Proof {
    /// F_t/F_n of the finger that bears most for how firmly it grips, low-passed.
    used: f64,
    /// What that was when the object was proved to hang.
    proved: Option<f64>,
    /// For how long the grip has not been as firm as that, s; without end as long as nothing is proved.
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
    /// Takes in one tick.
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

    /// The object hangs, as the hand grips it now.
    pub(super) fn prove(&mut self) {
        self.proved = Some(self.used);
    }

    /// Whether the grip is as firm as one that was proved.
    pub(super) fn stands(&self) -> bool {
        self.proved
            .is_some_and(|proved| self.used <= MARGIN * proved)
    }

    /// For how long it has not been, s; infinite as long as nothing is proved.
    pub(super) fn lapsed_s(&self) -> f64 {
        self.lapsed_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::perception::FingerPercept;

    /// Both fingers bear 1 N each: a second at `from_n` is proved; for how long the proof has lapsed after a second at `then_n`.
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
