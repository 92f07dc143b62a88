//! Load that the grip holds (not in the paper): the ratio of load to grip force that the contact
//! has been shown to hold.
//!
//! Friction is proportional to the grip force. If a force F_v has held the load L_v, a force F
//! holds L_v·F/F_v. Lift verification shows such a ratio; so does an object found in the hand. The
//! load is the net force across the closing axis. Shear between misaligned faces is not part of it.
//! The force pattern alone can indicate false slip: misaligned faces shear all elements uniformly.
//! While the grip holds the load, such a pattern is no evidence of slip.
//!
//! A load that exceeds this bound accelerates the object; integrated twice, it gives the slide.

use crate::filter::{Dwell, low_pass};
use crate::limits::{GRAVITY_M_S2, NORMAL_MIN_N};
use crate::perception::Percept;
use robot_model::PerSide;

/// Filter time constant of the ratio of filtered load to filtered force, s (design choice:
/// suppresses frame noise).
const RATIO_FILTER_S: f64 = 0.03;
/// Permitted multiple of the load that the grip can hold (design choice: covers hand tremor).
const MARGIN: f64 = 1.05;
/// Time for which the ratio of a found grip is measured, s (design choice: several filter time
/// constants; light objects are noisy).
const MEASURING_S: f64 = 0.15;
/// Filter time constant of load and force, s, and load below which noise requires a slower filter,
/// N (design choice).
const LOAD_FILTER_S: f64 = 0.004;
const LIGHT_LOAD_N: f64 = 0.3;
/// Time constant of the mean load and of its scatter, s (design choice: many periods of tremor).
const SCATTER_S: f64 = 0.7;

/// Present grip of an object, relative to the one that lift verification has shown to hold.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VerifiedGrip {
    /// Filtered net load across the closing axis, N.
    pub load_n: f64,
    /// Load that the present grip force holds, N.
    pub held_n: f64,
    /// Mean load of the last second, N.
    pub mean_n: f64,
    /// Standard deviation of the load, N.
    pub scatter_n: f64,
    /// Normal force of each side, N.
    pub normal_n: PerSide<f64>,
    /// Normal force of each side at the verification, N.
    pub verified_normal_n: PerSide<f64>,
    /// Distance by which the fingertips are closer to each other than at the verification, m.
    pub closed_m: f64,
}

/// Grip at the verification: normal force per side, N, and commanded opening, m.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Verification {
    normal_n: PerSide<f64>,
    opening_m: f64,
}

/// State of one grip, from first touch.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct GripVerification {
    /// Filtered net load, and normal force per side, N.
    load_n: f64,
    normal_n: PerSide<f64>,
    /// Mean of the filtered load, N, and variance around it, N².
    mean_load_n: f64,
    scatter_n2: f64,
    /// Force per side that only a drifted zero reports, N; negative if it hides force.
    drift_n: f64,
    /// Commanded opening, m.
    opening_m: f64,
    /// Filtered ratio of load to normal force, and the largest one that has held.
    load_ratio: Option<f64>,
    held_ratio: Option<f64>,
    verification: Option<Verification>,
    /// Remaining time for which the ratio of a found grip is measured, s.
    measuring_s: f64,
    /// Time since the grip last held its load; infinite if it never did.
    unheld: Dwell,
    /// Speed, m/s, and distance, m, of a slide under a load beyond what the grip can hold.
    overload_m_s: f64,
    overload_m: f64,
}

impl Default for GripVerification {
    fn default() -> Self {
        Self {
            load_n: 0.0,
            normal_n: PerSide::repeat(0.0),
            mean_load_n: 0.0,
            scatter_n2: 0.0,
            drift_n: 0.0,
            opening_m: 0.0,
            load_ratio: None,
            held_ratio: None,
            verification: None,
            measuring_s: 0.0,
            unheld: Dwell::FOREVER,
            overload_m_s: 0.0,
            overload_m: 0.0,
        }
    }
}

impl GripVerification {
    /// Creates the state of a found grip, which has held its object without a controller. The
    /// friction pattern starts without history: its first readings are too low, and would tighten
    /// the grip at every restart.
    pub(super) fn for_found_grip() -> Self {
        Self {
            held_ratio: Some(0.0),
            unheld: Dwell::default(),
            measuring_s: MEASURING_S,
            ..Self::default()
        }
    }

    /// Adds one tick: net load across the closing axis, N, drift of the zero, N per side, and
    /// commanded opening of the hand, m. Returns the present load and the load that the present
    /// grip holds; `None` without verification.
    pub(super) fn update(
        &mut self,
        percept: &Percept,
        (load_n, drift_n): (f64, f64),
        opening_m: f64,
    ) -> Option<VerifiedGrip> {
        let step_s = percept.step_s;
        (self.drift_n, self.opening_m) = (drift_n, opening_m);
        let filter_s = LOAD_FILTER_S * (1.0 + LIGHT_LOAD_N / load_n.max(NORMAL_MIN_N));
        self.load_n = low_pass(self.load_n, load_n, step_s, filter_s);
        for (normal_n, side) in self.normal_n.iter_mut().zip(&percept.sides) {
            *normal_n = low_pass(*normal_n, side.normal_n, step_s, filter_s);
        }
        self.mean_load_n = low_pass(self.mean_load_n, self.load_n, step_s, SCATTER_S);
        let off_n = self.load_n - self.mean_load_n;
        self.scatter_n2 = low_pass(self.scatter_n2, off_n * off_n, step_s, SCATTER_S);
        let grip = self.verified_grip();
        self.update_overload(grip, step_s);
        let ratio = self.load_n / self.total_normal_n().max(NORMAL_MIN_N);
        let before = self.load_ratio.unwrap_or(ratio);
        let filtered = low_pass(before, ratio, step_s, RATIO_FILTER_S);
        self.load_ratio = Some(filtered);
        if self.measuring_s > 0.0 {
            self.measuring_s -= step_s;
            self.held_ratio = self.held_ratio.map(|held| held.max(filtered));
        }
        self.unheld.update(!self.is_held(), step_s);
        grip
    }

    /// A minimised grip has held the suspended object without a drop.
    pub(super) fn set_held(&mut self) {
        self.held_ratio = self.load_ratio;
    }

    /// The object stands or drops: what the grip holds is unknown again.
    pub(super) fn forget(&mut self) {
        (self.held_ratio, self.verification) = (None, None);
    }

    /// Lift verification has shown that the present grip holds the present load.
    pub(super) fn set_verified(&mut self) {
        self.held_ratio = Some(self.load_n / self.total_normal_n().max(NORMAL_MIN_N));
        self.verification = Some(Verification {
            normal_n: self.normal_n,
            opening_m: self.opening_m,
        });
    }

    fn verified_grip(&self) -> Option<VerifiedGrip> {
        let (ratio, verification) = self.held_ratio.zip(self.verification)?;
        Some(VerifiedGrip {
            load_n: self.load_n,
            held_n: ratio * self.total_normal_n(),
            mean_n: self.mean_load_n,
            scatter_n: libm::sqrt(self.scatter_n2),
            normal_n: self.normal_n,
            verified_normal_n: verification.normal_n,
            closed_m: verification.opening_m - self.opening_m,
        })
    }

    /// Returns the grip force of both sides without the drift of the zero, N.
    fn total_normal_n(&self) -> f64 {
        self.normal_n
            .iter()
            .map(|normal_n| normal_n - self.drift_n)
            .sum()
    }

    /// Integrates the acceleration by the part of the load that the grip cannot hold. The measured
    /// load of a sliding object is friction only, so the true distance may be larger.
    fn update_overload(&mut self, grip: Option<VerifiedGrip>, step_s: f64) {
        let excess = grip.map_or(0.0, |grip| {
            1.0 - MARGIN * grip.held_n.max(grip.mean_n) / grip.load_n.max(NORMAL_MIN_N)
        });
        if excess > 0.0 {
            self.overload_m_s += GRAVITY_M_S2 * excess * step_s;
            self.overload_m += self.overload_m_s * step_s;
        } else {
            (self.overload_m_s, self.overload_m) = (0.0, 0.0);
        }
    }

    /// Estimated distance of a slide under a sudden load, m.
    pub(super) fn overload_m(&self) -> f64 {
        self.overload_m
    }

    /// Returns true while the present grip has been shown to hold the present load.
    pub(super) fn is_held(&self) -> bool {
        self.held_ratio
            .zip(self.load_ratio)
            .is_some_and(|(held, now)| now <= MARGIN * held)
    }

    /// Time since the grip last held its load, s; infinite if it never did.
    pub(super) fn unheld_s(&self) -> f64 {
        self.unheld.seconds()
    }
}

#[cfg(test)]
mod tests;
