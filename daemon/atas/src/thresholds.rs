//! Force thresholds F_1 and F_2 from the object's stiffness (paper II.b (1): "Threshold of maximum
//! grasping force F_2 should be changed based on the object's hardness"). The laws come from a
//! prototype; *stiffness*, N/m, is the paper's *hardness*.

use crate::settings::Grasp;
use shm_schemas::{ModuleId, Reason};

/// Largest F_1/F_2, so that Modules 1 and 3 never contradict each other.
const F1_BELOW_F2: f64 = 0.8;

/// F_2 of an existing grip without known force limit, in multiples of its force. Design choice: one
/// step of lift verification.
const EXISTING_GRIP_FACTOR: f64 = 1.2;

/// Source of F_2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ForceLimitSource {
    /// The hand's force limit (`grasp.f2_max_n`).
    Hand,
    /// The object's stiffness.
    Object,
    /// The force limit in the client's goal.
    Goal,
}

/// Grip force thresholds.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Thresholds {
    /// F_1: minimum grip force, N.
    pub f1_n: f64,
    /// F_2: maximum grip force, N.
    pub f2_n: f64,
    /// Source of F_2.
    pub source: ForceLimitSource,
}

impl Thresholds {
    /// Returns the thresholds for a stiffness, N/m: F_2 compresses the object by `compression_m`.
    ///
    /// ```
    /// use atas_core::Settings;
    /// use atas_core::thresholds::Thresholds;
    ///
    /// let grasp = Settings::default().grasp;
    /// let soft = Thresholds::for_stiffness(500.0, &grasp);
    /// let stiff = Thresholds::for_stiffness(20_000.0, &grasp);
    /// assert!(soft.f2_n < stiff.f2_n, "a stiffer object tolerates more force");
    /// ```
    #[must_use]
    pub fn for_stiffness(object_n_m: f64, settings: &Grasp) -> Self {
        let f2_n = clamp_to_upper(
            settings.compression_m * object_n_m,
            settings.f2_min_n,
            settings.f2_max_n,
        );
        let bound = if f2_n < settings.f2_max_n {
            ForceLimitSource::Object
        } else {
            ForceLimitSource::Hand
        };
        Self::with_f2(f2_n, bound, settings)
    }

    /// Applies a goal's force limit, N; zero means none.
    #[must_use]
    pub fn with_force_limit(self, max_force_n: f64, settings: &Grasp) -> Self {
        if max_force_n > 0.0 {
            Self::with_f2(
                max_force_n.min(settings.f2_max_n),
                ForceLimitSource::Goal,
                settings,
            )
        } else {
            self
        }
    }

    /// Returns the thresholds for an existing grip from its weakest and strongest force and the
    /// reported F_2, N, zero if none.
    #[must_use]
    pub fn for_existing_grip(
        [weakest_n, strongest_n]: [f64; 2],
        reported_f2_n: f64,
        settings: &Grasp,
    ) -> Self {
        let known = reported_f2_n.is_finite() && reported_f2_n >= settings.carry_min_n;
        let f2_n = if known {
            reported_f2_n.min(settings.f2_max_n)
        } else {
            EXISTING_GRIP_FACTOR * strongest_n
        };
        Self {
            f1_n: weakest_n.min(F1_BELOW_F2 * f2_n),
            f2_n,
            source: ForceLimitSource::Hand,
        }
    }

    /// Returns the largest grip force before F_2 is known, N.
    #[must_use]
    pub fn force_ceiling_n(&self, settings: &Grasp) -> f64 {
        match self.source {
            ForceLimitSource::Goal => self.f2_n,
            ForceLimitSource::Hand | ForceLimitSource::Object => settings.f2_max_n,
        }
    }

    /// Returns the reason to refuse an object that needs more than F_2, found by a module at this
    /// force, N.
    #[must_use]
    pub fn refusal(&self, force_n: f64, module: ModuleId) -> Reason {
        let limit_n = self.f2_n;
        match self.source {
            ForceLimitSource::Hand => Reason::TooHeavy {
                force_n,
                limit_n,
                module,
            },
            ForceLimitSource::Object => Reason::TooSoft {
                force_n,
                limit_n,
                module,
            },
            ForceLimitSource::Goal => Reason::AboveMaxForce {
                force_n,
                limit_n,
                module,
            },
        }
    }

    /// Returns the thresholds for an unknown object, as for the softest.
    #[must_use]
    pub fn for_unknown_object(settings: &Grasp) -> Self {
        Self::for_stiffness(0.0, settings)
    }

    fn with_f2(f2_n: f64, bound: ForceLimitSource, settings: &Grasp) -> Self {
        let f1_n = clamp_to_upper(
            settings.f1_share * f2_n + settings.f1_base_n,
            settings.f1_min_n,
            settings.f1_max_n,
        );
        Self {
            f1_n: f1_n.min(F1_BELOW_F2 * f2_n),
            f2_n,
            source: bound,
        }
    }
}

/// Clamps without panic; with contradictory bounds the upper, gentler one wins.
fn clamp_to_upper(value: f64, lower: f64, upper: f64) -> f64 {
    value.max(lower).min(upper)
}
