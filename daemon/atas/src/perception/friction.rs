//! Friction utilisation S: share of the available friction that the contact uses, from the force
//! distribution over the patch.
//!
//! Elements at the rim slip before the whole contact does (incipient slip). Their ratio of
//! tangential to normal force gives the friction coefficient, to which S relates the ratio of the
//! contact. Unlike `dF_t > dr`, S also detects imminent slip under constant forces (source:
//! prototype). Both ratios use forces along the shear direction, torsion included, so that noise
//! and crosstalk average out. Slip observed by other evidence corrects the estimate for the rest of
//! the contact.
//!
//! Only a face curved in both directions shows incipient slip on every object. A flat face presses
//! evenly or with an edge, a cylinder along a line, and a single element has no pattern. For these,
//! friction is unknown until other evidence gives the ratio at slip. With the pattern instead, flat
//! pads refused 11 to 20 % of the objects that they can hold, and cylinders 17 to 25 %.

use super::patch::{MostLoaded, Patch};
use crate::filter::low_pass;
use crate::limits::{
    FRICTION_CLIP, FRICTION_FLOOR, FRICTION_RELAX_S, NORMAL_MIN_N, TANGENTIAL_FLOOR_N,
};
use crate::settings::Settings;

/// Upper limit of the utilisation.
const UTILISATION_CLIP: f64 = 1.2;
/// Smallest friction reading used as a divisor (prototype: 0.03).
const READING_FLOOR: f64 = 0.03;
/// Decay time constant of the recent maximum, s (design choice: detection time of slip).
const RECENT_S: f64 = 0.3;
/// Momentary utilisation that ends gross slip (design choice: well below its start).
const GROSS_END_UTILISATION: f64 = 0.9;
/// Share of the largest F_t/F_n of an episode below which the object sticks again (design choice:
/// more than the scatter of kinetic friction).
const SLIDING_SHARE: f64 = 0.96;
/// Time constant of that ratio, s (design choice: a few frames of noise).
const RATIO_FILTER_S: f64 = 0.03;

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FrictionEstimate {
    pub(super) utilisation: f64,
    pub(super) utilisation_now: f64,
    pub(super) friction: f64,
    pub(super) gross_s: f64,
    pub(super) error: f64,
}

/// State of one contact, from first touch to release.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Friction {
    /// μ̂: largest reading since first touch.
    remembered: f64,
    /// S_inst: low-passed utilisation relative to the present reading.
    utilisation_now: f64,
    gross_s: f64,
    /// Low-passed F_t/F_n, and its maximum since uniform shear began; 0 between episodes.
    filtered_ratio: f64,
    episode_max_ratio: f64,
    /// Recent maximum of F_t/F_n.
    recent_ratio: f64,
    /// F_t/F_n at an observed slip, the upper limit of friction.
    slip_ratio: Option<f64>,
}

impl Friction {
    /// Adds one patch. `steady` evaluates the most loaded elements after the friction filter, under
    /// shear only; they are thus unaffected by noise. `slips` reports slip detected by other
    /// evidence.
    pub(super) fn update(
        &mut self,
        patch: &Patch,
        is_round: bool,
        steady: impl FnOnce() -> Option<MostLoaded>,
        slips: bool,
        step_s: f64,
        settings: &Settings,
    ) -> FrictionEstimate {
        let tangential_n = patch.loaded_along_n;
        let ratio = tangential_n / (NORMAL_MIN_N + patch.loaded_normal_n);
        let is_sheared = tangential_n > TANGENTIAL_FLOOR_N;
        if !is_round {
            self.gross_s = 0.0;
            self.record_slip(ratio, slips, step_s, settings);
            return self.estimate_from_slip(ratio);
        }
        let most_loaded = if is_sheared { steady() } else { None };
        let Some(loaded) = most_loaded else {
            self.gross_s = 0.0;
            return FrictionEstimate {
                friction: self.remembered,
                ..FrictionEstimate::default()
            };
        };
        let share = step_s / (settings.perception.friction_filter_s + step_s);
        // m_raw: ratio of the most loaded elements; low-passed, because their forces are.
        let reading = loaded.ratio.min(FRICTION_CLIP);
        self.remembered = if reading > self.remembered {
            reading
        } else {
            self.remembered
        };
        self.utilisation_now += (ratio / reading.max(READING_FLOOR) - self.utilisation_now) * share;
        self.update_gross_slip(ratio, step_s, settings);
        self.record_slip(ratio, slips, step_s, settings);
        FrictionEstimate {
            utilisation: (ratio / self.remembered.max(FRICTION_FLOOR)).min(UTILISATION_CLIP),
            utilisation_now: self.utilisation_now,
            friction: self.remembered,
            gross_s: self.gross_s,
            error: loaded.error,
        }
    }

    /// Returns the estimate without the force pattern.
    fn estimate_from_slip(&self, ratio: f64) -> FrictionEstimate {
        let Some(slid_at) = self.slip_ratio else {
            return FrictionEstimate::default();
        };
        let utilisation = (ratio / slid_at.max(FRICTION_FLOOR)).min(UTILISATION_CLIP);
        FrictionEstimate {
            utilisation,
            utilisation_now: utilisation,
            friction: slid_at,
            ..FrictionEstimate::default()
        }
    }

    /// Lowers the remembered friction to the ratio at an observed slip.
    fn record_slip(&mut self, ratio: f64, slips: bool, step_s: f64, settings: &Settings) {
        let filter_s = if ratio > self.recent_ratio {
            settings.perception.friction_filter_s
        } else {
            RECENT_S
        };
        self.recent_ratio = low_pass(self.recent_ratio, ratio, step_s, filter_s);
        if slips {
            self.slip_ratio = Some(
                self.slip_ratio
                    .unwrap_or(f64::INFINITY)
                    .min(self.recent_ratio),
            );
        }
        if let Some(slid_at) = self.slip_ratio.filter(|slid_at| *slid_at < self.remembered) {
            self.remembered = slid_at;
        }
    }

    /// Relaxes the remembered friction to F_t/F_n during gross slip. A patch stays uniformly
    /// sheared after it sticks again, until it is reloaded. Therefore only a ratio near the maximum
    /// of the episode counts as sliding.
    fn update_gross_slip(&mut self, ratio: f64, step_s: f64, settings: &Settings) {
        self.filtered_ratio = low_pass(self.filtered_ratio, ratio, step_s, RATIO_FILTER_S);
        let alike = self.utilisation_now > settings.grasp.slip_gross;
        if self.utilisation_now < GROSS_END_UTILISATION {
            self.episode_max_ratio = 0.0;
        } else if alike && self.filtered_ratio > self.episode_max_ratio {
            self.episode_max_ratio = self.filtered_ratio;
        }
        self.gross_s = if alike && self.filtered_ratio > SLIDING_SHARE * self.episode_max_ratio {
            self.gross_s + step_s
        } else {
            0.0
        };
        if self.gross_s > settings.grasp.slip_gross_s {
            let share = step_s / (FRICTION_RELAX_S + step_s);
            self.remembered += (ratio - self.remembered) * share;
        }
    }
}
