//! Findings of the estimator: states and reasons that the task executor reads.

use super::estimate::HeldObject;
use super::estimator::HeldObjectEstimator;
use crate::perception::StiffnessFit;
use crate::thresholds::Thresholds;
use shm_schemas::{Hand, Reason};

/// Contact loss of a gripped object until it counts as lost, s (design choice: longer than contact
/// bounce).
const LOST_AFTER_S: f64 = 0.05;
/// Duration of a drift before a warning, s (design choice: longer than a disturbance).
const DRIFT_WARNING_S: f64 = 0.5;

impl HeldObjectEstimator {
    /// Estimate of this tick.
    #[must_use]
    pub fn object(&self) -> &HeldObject {
        &self.object
    }

    /// F_1 and F_2.
    #[must_use]
    pub fn thresholds(&self) -> Thresholds {
        self.object.thresholds
    }

    /// Estimated stiffness, once known.
    #[must_use]
    pub fn stiffness(&self) -> Option<StiffnessFit> {
        self.stiffness
    }

    /// Returns true if the hand grips an object that touches every side.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.is_gripped && !self.has_lost_contact()
    }

    /// The fingers have gripped an object, and nothing has opened them since.
    #[must_use]
    pub fn is_gripped(&self) -> bool {
        self.is_gripped
    }

    /// The object was found in the hand.
    #[must_use]
    pub fn is_found(&self) -> bool {
        self.is_found
    }

    /// Lift verification has succeeded.
    #[must_use]
    pub fn is_verified(&self) -> bool {
        self.is_verified
    }

    /// A side has not touched for longer than contact bounce.
    #[must_use]
    pub fn has_lost_contact(&self) -> bool {
        self.no_contact.seconds() > LOST_AFTER_S
    }

    /// The hand has begun to carry a gripped object.
    #[must_use]
    pub fn is_carried(&self) -> bool {
        self.is_gripped && self.contact.is_lifted()
    }

    /// Duration of a drop of a verified object, s.
    #[must_use]
    pub fn drop_s(&self) -> f64 {
        self.dropping.seconds()
    }

    /// Time since the grip was last shown to hold its load, s; infinite if it never was.
    #[must_use]
    pub fn unheld_s(&self) -> f64 {
        self.verification.unheld_s()
    }

    /// Estimated distance of a slide under a sudden load, m.
    #[must_use]
    pub fn overload_m(&self) -> f64 {
        self.verification.overload_m()
    }

    /// Lever of the centre of mass, m; positive 90° anticlockwise of the closing axis.
    #[must_use]
    pub fn lever_m(&self) -> f64 {
        self.lever.max_m()
    }

    /// The lever no longer grows.
    #[must_use]
    pub fn lever_is_known(&self) -> bool {
        self.lever.has_peaked()
    }

    /// Returns the reason if the object no longer loads the hand.
    #[must_use]
    pub fn loss(&self) -> Option<Reason> {
        self.weight.loss().filter(|_| self.is_gripped)
    }

    /// Returns the reason if the object keeps rotating in the hand.
    #[must_use]
    pub fn turning(&self) -> Option<Reason> {
        self.lever.turning()
    }

    /// Returns the reason if the object has moved in the hand, or no longer loads it fully: a
    /// completed task has then failed.
    #[must_use]
    pub fn failure(&self) -> Option<Reason> {
        let slip = self.weight.slip().or_else(|| self.weight.lightening());
        slip.or_else(|| self.lever.rotation())
    }

    /// Returns the warning reason if the grip force does not match the opening of this hand.
    #[must_use]
    pub fn drift_warning(&self, hand: Hand) -> Option<Reason> {
        let grip = self.object.grip?;
        let [now_n, verified_n] = [grip.normal_n, grip.verified_normal_n].map(|n| n.mean());
        (self.drifting.seconds() > DRIFT_WARNING_S).then_some(Reason::ForceAgainstOpening {
            hand,
            force_n: now_n,
            lift_force_n: verified_n,
        })
    }
}
