//! F_1 and F_2 from the object's stiffness (paper II.b (1): "Threshold of maximum grasping force F_2 should be changed
//! based on the object's hardness"; the laws are ours, from a prototype). What the paper calls hardness is measured in
//! N/m, so it is called stiffness everywhere here.

use crate::settings::Grasp;
use shm_schemas::Cause;

/// Share of F_2 that F_1 never exceeds, so that Module 1 and Module 3 never contradict each other.
const F1_BELOW_F2: f64 = 0.8;

/// Multiple of the force found on an object up to which it may be pressed, if nobody tells how much it bears (ours, as one
/// step of the load test).
const KEEP_FACTOR: f64 = 1.2;

/// What sets F_2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Bound {
    /// What the fingers may ever press (`grasp.f2_max_n`).
    Hand,
    /// The object's stiffness.
    Object,
    /// The goal, whose client knows what the object bears.
    Goal,
}

/// The two thresholds of the grasping force.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Thresholds {
    /// F_1: minimum grasping force, N.
    pub f1_n: f64,
    /// F_2: maximum grasping force, N.
    pub f2_n: f64,
    /// What sets F_2.
    pub bound: Bound,
}

impl Thresholds {
    /// For an object of known stiffness, N/m: F_2 compresses it by `compression_m`.
    #[must_use]
    pub fn for_stiffness(object_n_m: f64, settings: &Grasp) -> Self {
        let f2_n = between(
            settings.compression_m * object_n_m,
            settings.f2_min_n,
            settings.f2_max_n,
        );
        let bound = if f2_n < settings.f2_max_n {
            Bound::Object
        } else {
            Bound::Hand
        };
        Self::with_f2(f2_n, bound, settings)
    }

    /// The same for an object of which the goal's client knows what it bears, N; zero if he does not.
    #[must_use]
    pub fn told(self, max_force_n: f64, settings: &Grasp) -> Self {
        if max_force_n > 0.0 {
            Self::with_f2(max_force_n.min(settings.f2_max_n), Bound::Goal, settings)
        } else {
            self
        }
    }

    /// For what the hand was found pressing with these forces, the weakest and the strongest, N, and of which F_2 is told, N;
    /// zero if it is not.
    #[must_use]
    pub fn found([weakest_n, strongest_n]: [f64; 2], told_n: f64, settings: &Grasp) -> Self {
        let told = told_n.is_finite() && told_n >= settings.keep_n;
        let f2_n = if told {
            told_n.min(settings.f2_max_n)
        } else {
            KEEP_FACTOR * strongest_n
        };
        Self {
            f1_n: weakest_n.min(F1_BELOW_F2 * f2_n),
            f2_n,
            bound: Bound::Hand,
        }
    }

    /// Most that the fingers may press an object with before F_2 is known, N.
    #[must_use]
    pub fn most_n(&self, settings: &Grasp) -> f64 {
        match self.bound {
            Bound::Goal => self.f2_n,
            Bound::Hand | Bound::Object => settings.f2_max_n,
        }
    }

    /// Why an object that needs more than F_2 is refused.
    #[must_use]
    pub fn exceeded(&self) -> Cause {
        match self.bound {
            Bound::Hand => Cause::TOO_HEAVY,
            Bound::Object => Cause::TOO_SOFT,
            Bound::Goal => Cause::ABOVE_MAX_FORCE,
        }
    }

    /// For an object that is not yet known: as careful as for the softest.
    #[must_use]
    pub fn unknown(settings: &Grasp) -> Self {
        Self::for_stiffness(0.0, settings)
    }

    fn with_f2(f2_n: f64, bound: Bound, settings: &Grasp) -> Self {
        let f1_n = between(
            settings.f1_share * f2_n + settings.f1_base_n,
            settings.f1_min_n,
            settings.f1_max_n,
        );
        Self {
            f1_n: f1_n.min(F1_BELOW_F2 * f2_n),
            f2_n,
            bound,
        }
    }
}

/// Bounds that contradict each other must not stop the tick: the upper one wins, as the gentler.
fn between(value: f64, lower: f64, upper: f64) -> f64 {
    value.max(lower).min(upper)
}
