//! F_1 and F_2 from the object's stiffness (paper II.b (1): "Threshold of maximum grasping force F_2 should be changed
//! based on the object's hardness"; the laws are ours, from a prototype). What the paper calls hardness is measured in
//! N/m, so it is called stiffness everywhere here.

use crate::settings::Grasp;

/// Share of F_2 that F_1 never exceeds, so that Module 1 and Module 3 never contradict each other.
const F1_BELOW_F2: f64 = 0.8;

/// The two thresholds of the grasping force.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Thresholds {
    /// F_1: minimum grasping force, N.
    pub f1_n: f64,
    /// F_2: maximum grasping force, N.
    pub f2_n: f64,
}

impl Thresholds {
    /// For an object of known stiffness, N/m: F_2 compresses it by `compression_m`.
    #[must_use]
    pub fn for_stiffness(object_n_m: f64, settings: &Grasp) -> Self {
        Self::with_f2(
            between(
                settings.compression_m * object_n_m,
                settings.f2_min_n,
                settings.f2_max_n,
            ),
            settings,
        )
    }

    /// For an object that is not yet known: as careful as for the softest.
    #[must_use]
    pub fn unknown(settings: &Grasp) -> Self {
        Self::for_stiffness(0.0, settings)
    }

    fn with_f2(f2_n: f64, settings: &Grasp) -> Self {
        let f1_n = between(
            settings.f1_share * f2_n + settings.f1_base_n,
            settings.f1_min_n,
            settings.f1_max_n,
        );
        Self {
            f1_n: f1_n.min(F1_BELOW_F2 * f2_n),
            f2_n,
        }
    }
}

/// Bounds that contradict each other must not stop the tick: the upper one wins, as the gentler.
fn between(value: f64, lower: f64, upper: f64) -> f64 {
    value.max(lower).min(upper)
}
