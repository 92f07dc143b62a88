//! Estimate of the held object in one tick, and what the estimator needs to know of the task.

use super::drift::Drift;
use super::verified_grip::VerifiedGrip;
use crate::thresholds::Thresholds;

/// Estimate of the object in the hand.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HeldObject {
    /// F_1 and F_2.
    pub thresholds: Thresholds,
    /// Minimum normal force per grasp side, N: F_1 at first touch, less once the object is carried.
    pub min_force_n: f64,
    /// Every side has touched since the fingers began to close.
    pub all_touched: bool,
    /// Total measured closing since every side touched, m.
    pub closing_m: f64,
    /// Distance over which the object was carried, m.
    pub carried_m: f64,
    /// Vertical load on the hand, N, positive downwards.
    pub down_n: f64,
    /// Only the hand carries the object, as far as verified.
    pub suspended: bool,
    /// The object is suspended above its support and not being set down.
    pub carried_freely: bool,
    /// Lift verification minimises the grip, just above the support, where a slip is harmless.
    pub minimises_grip: bool,
    /// A change of speed makes the object swing.
    pub swings: bool,
    /// The object slips through the fingers, because its load decreases.
    pub drops: bool,
    /// The present grip has been shown to hold the present load. The force pattern is then no
    /// evidence of slip.
    pub load_is_held: bool,
    /// Present grip relative to the verified one; `None` without lift verification.
    pub grip: Option<VerifiedGrip>,
    /// Drift of the tactile zero.
    pub drift: Drift,
}

impl HeldObject {
    /// Returns the estimate before the first touch.
    #[must_use]
    pub fn untouched(thresholds: Thresholds) -> Self {
        Self {
            thresholds,
            min_force_n: thresholds.f1_n,
            all_touched: false,
            closing_m: 0.0,
            carried_m: 0.0,
            down_n: 0.0,
            suspended: false,
            carried_freely: false,
            minimises_grip: false,
            swings: false,
            drops: false,
            load_is_held: false,
            grip: None,
            drift: Drift::default(),
        }
    }
}

/// Properties of the present step that the estimator depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepFacts {
    /// The fingers close towards the first touch.
    pub searches: bool,
    /// Lift verification decides whether the object is suspended; otherwise it is assumed to be.
    pub verifies_lift: bool,
    /// The hand sets the object down.
    pub lowers: bool,
    /// The hand steadies the object, while the other hand works on it.
    pub steadies: bool,
    /// A slip or a rotation of the object would be a failure of the task.
    pub is_monitored: bool,
}

/// Result of lift verification in one tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum LiftFinding {
    /// No result yet.
    #[default]
    None,
    /// The object stands on its support, or drops from a minimised grip.
    Standing,
    /// The grip is to be minimised, before the next verification.
    MinimisesGrip,
    /// Only the hand carries the object.
    Suspended,
}
