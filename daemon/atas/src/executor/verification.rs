//! Grip verification: remembers the force ratio F_t/F_n at which lift verification succeeded
//! (design choice, not in the paper).
//!
//! The force pattern alone can indicate false slip: misaligned faces shear all elements uniformly,
//! and more so at higher grip force. While no side exceeds the verified ratio, pattern-based slip
//! triggers no pressing, warning or rejection. Dropping is detected by weight ([`crate::modules`],
//! Module 2, cause (e)) and is never suppressed.
//!
//! Friction is proportional to the grip force. The ratio of net load to grip force at the
//! verification therefore gives the load that another grip force holds. Shear between misaligned
//! faces is not part of the net load. Module 2, cause (f), follows a larger load.

use crate::filter::low_pass;
use crate::limits::{GRAVITY_M_S2, NORMAL_MIN_N};
use crate::modules::VerifiedGrip;
use crate::perception::Percept;
use robot_model::GRASP_SIDES;

/// Filter time constant of F_t/F_n, s (design choice: suppresses frame noise).
const FILTER_S: f64 = 0.03;
/// Permitted multiple of the verified F_t/F_n, and of the load that the grip can hold (design
/// choice: covers hand tremor).
const MARGIN: f64 = 1.05;

/// Time for which the ratio of a found grip is measured, s (design choice: several filter time
/// constants; light objects are noisy).
const MEASURING_S: f64 = 0.15;
/// Filter time constant of the net load, s, and load below which noise requires a slower filter, N
/// (design choice).
const LOAD_FILTER_S: f64 = 0.004;
const LIGHT_LOAD_N: f64 = 0.3;
/// Time constant of the mean load and of its scatter, s (design choice: many periods of tremor).
const SCATTER_S: f64 = 0.7;

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
    /// Remaining time for which the ratio of a found grip is measured, s.
    measuring_s: f64,
    /// Filtered net load, and normal force per side, N.
    load_n: f64,
    normal_n: [f64; GRASP_SIDES],
    /// Mean of the filtered load, N, and variance around it, N².
    mean_load_n: f64,
    scatter_n2: f64,
    /// Ratio of load to normal force at the verification.
    verified_load_ratio: Option<f64>,
    /// Normal force per side at the verification, N.
    verified_normal_n: [f64; GRASP_SIDES],
    /// Commanded opening at present and at the verification, m.
    opening_m: f64,
    verified_opening_m: f64,
    /// Speed, m/s, and distance, m, of a slide under a sudden load beyond what the grip can hold.
    overload_m_s: f64,
    overload_m: f64,
}

impl Default for GripVerification {
    fn default() -> Self {
        Self {
            force_ratio: 0.0,
            verified_ratio: None,
            unverified_s: f64::INFINITY,
            measuring_s: 0.0,
            load_n: 0.0,
            normal_n: [0.0; GRASP_SIDES],
            mean_load_n: 0.0,
            scatter_n2: 0.0,
            verified_load_ratio: None,
            verified_normal_n: [0.0; GRASP_SIDES],
            opening_m: 0.0,
            verified_opening_m: 0.0,
            overload_m_s: 0.0,
            overload_m: 0.0,
        }
    }
}

impl GripVerification {
    /// Creates the state of a found grip, which has held its object without a controller. The
    /// friction pattern starts without history: its first readings are too low, and would tighten
    /// the grip at every restart.
    pub(super) fn for_found_grip(percept: &Percept) -> Self {
        let force_ratio = largest_force_ratio(percept);
        Self {
            force_ratio,
            verified_ratio: Some(force_ratio),
            unverified_s: 0.0,
            measuring_s: MEASURING_S,
            ..Self::default()
        }
    }

    /// Updates the ratios from one tick. Inputs: net load across the closing axis, N, and commanded
    /// opening of the hand, m.
    pub(super) fn update(&mut self, percept: &Percept, load_n: f64, opening_m: f64) {
        self.opening_m = opening_m;
        let filter_s = LOAD_FILTER_S * (1.0 + LIGHT_LOAD_N / load_n.max(NORMAL_MIN_N));
        self.load_n = low_pass(self.load_n, load_n, percept.step_s, filter_s);
        for (normal_n, side) in self.normal_n.iter_mut().zip(&percept.sides) {
            *normal_n = low_pass(*normal_n, side.normal_n, percept.step_s, filter_s);
        }
        self.mean_load_n = low_pass(self.mean_load_n, self.load_n, percept.step_s, SCATTER_S);
        let off_n = self.load_n - self.mean_load_n;
        self.scatter_n2 = low_pass(self.scatter_n2, off_n * off_n, percept.step_s, SCATTER_S);
        self.update_overload(percept.step_s);
        let ratio = largest_force_ratio(percept);
        self.force_ratio = low_pass(self.force_ratio, ratio, percept.step_s, FILTER_S);
        if self.measuring_s > 0.0 {
            self.measuring_s -= percept.step_s;
            let largest = |verified: f64| verified.max(self.force_ratio);
            self.verified_ratio = self.verified_ratio.map(largest);
        }
        self.unverified_s = if self.is_verified() {
            0.0
        } else {
            self.unverified_s + percept.step_s
        };
    }

    /// Marks the object as suspended at the present ratio.
    pub(super) fn set_verified(&mut self) {
        self.verified_ratio = Some(self.force_ratio);
        self.verified_load_ratio = Some(self.load_n / self.total_normal_n().max(NORMAL_MIN_N));
        self.verified_normal_n = self.normal_n;
        self.verified_opening_m = self.opening_m;
    }

    /// Returns the present load and the load that the present grip holds; `None` without
    /// verification.
    pub(super) fn verified_grip(&self) -> Option<VerifiedGrip> {
        let ratio = self.verified_load_ratio?;
        Some(VerifiedGrip {
            load_n: self.load_n,
            held_n: ratio * self.total_normal_n(),
            mean_n: self.mean_load_n,
            scatter_n: libm::sqrt(self.scatter_n2),
            normal_n: self.normal_n,
            verified_normal_n: self.verified_normal_n,
            closed_m: self.verified_opening_m - self.opening_m,
        })
    }

    fn total_normal_n(&self) -> f64 {
        self.normal_n.iter().sum()
    }

    /// Integrates the acceleration by the part of the load that the grip cannot hold. The measured
    /// load of a sliding object is friction only, so the true distance may be larger.
    fn update_overload(&mut self, step_s: f64) {
        let excess = self.verified_grip().map_or(0.0, |grip| {
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

/// Returns the largest F_t/F_n of the grasp sides.
fn largest_force_ratio(percept: &Percept) -> f64 {
    let sides = percept.sides.iter();
    sides
        .map(|side| side.tangential_n / side.normal_n.max(NORMAL_MIN_N))
        .fold(0.0, |most, ratio| if ratio > most { ratio } else { most })
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
                let percept = Percept {
                    sides: [finger; 2],
                    step_s: 1e-3,
                    ..Percept::default()
                };
                proof.update(&percept, 2.0, 0.05);
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
