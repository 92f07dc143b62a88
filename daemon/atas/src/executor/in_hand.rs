//! In-hand monitor: detects slip, rotation and loss of the carried object from tactile data.
//!
//! * **Slip**: the missing load accelerates a suspended object; integrated twice, it gives the slip
//!   distance. A supported object slips by the hand travel.
//! * **Rotation**: an off-centre mass loads the fingertips with a moment about the closing axis.
//!   The lever (moment over weight) shrinks when the object rotates and its centre of mass swings
//!   below the grip.
//! * **Loss**: a lost object loads no finger, in neither direction, even if a drifting sensor still
//!   reports grip force.

use crate::filter::low_pass;
use crate::limits::GRAVITY_M_S2;
use crate::modules::{Finding, load_n};
use crate::perception::Percept;
use shm_schemas::{Cause, Reason};

/// Slip beyond which a task fails, m (design choice: 3 mm minus the estimation error).
const SLIP_MAX_M: f64 = 0.0028;
/// Filter time constant of moment and lever, s (design choice: one period of hand tremor).
const FILTER_S: f64 = 0.05;
/// Total load below which noise requires a slower filter, N (design choice).
const LIGHT_LOAD_N: f64 = 0.3;
/// Filter time constant of the weight, s (design choice).
const WEIGHT_S: f64 = 0.7;
/// Minimum total load for a lever estimate, N (design choice: several times the sensor noise).
const LOAD_MIN_N: f64 = 0.05;
/// Pairs of minimum torsion ratio and maximum remaining lever share of a rotated object (design
/// choice, measured with centres of mass up to 5 mm off-centre).
const TURNING: [[f64; 2]; 2] = [[0.6, 0.9], [0.5, 0.7]];
/// Minimum duration of a rotation, s (design choice: longer than one swing).
const TURNING_S: f64 = 0.3;
/// Share of its weight below which an object counts as lost, and the minimum duration, s (design
/// choice).
const LOSS_SHARE: f64 = 0.3;
const LOSS_S: f64 = 0.2;
/// Decay time constant of the maximum weight, s (design choice: longer than a lift).
const WEIGHT_MAX_S: f64 = 10.0;

/// State of one hold, from the start of the lift.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct InHandMonitor {
    /// Filtered lever about the closing axis, m.
    lever_m: f64,
    /// Signed lever, m: positive 90° anticlockwise of the closing axis, seen from above.
    signed_lever_m: f64,
    torsion: f64,
    lever_max_m: f64,
    torsion_max: f64,
    turned_s: f64,
    /// Weight before any slip, N (0: unknown), and its measuring time, s.
    weight_n: f64,
    weighed_s: f64,
    /// Variance of the load around the weight, N².
    scatter_n2: f64,
    /// Slowly decaying maximum weight, N; detects objects that slide out slowly.
    weight_max_n: f64,
    slip_m_s: f64,
    slip_m: f64,
    /// Carried distance at which the object was last verified as supported, m.
    supported_at_m: f64,
    loss_s: f64,
    /// Magnitude of the present vertical load, N.
    load_n: f64,
}

impl InHandMonitor {
    /// Processes one tick: percept, vertical load, N, carried distance, m, and module findings.
    /// Without lift verification, the slip of a supported object is unknown.
    pub(super) fn update(
        &mut self,
        percept: &Percept,
        down_n: f64,
        carried_m: f64,
        (finding, hangs, is_tested): (Finding, bool, bool),
    ) {
        let step_s = percept.step_s;
        if carried_m <= 0.0 || step_s <= 0.0 {
            return;
        }
        if finding.slips && !hangs && is_tested {
            self.slip_m += (carried_m - self.supported_at_m).max(0.0);
            self.supported_at_m = carried_m;
        }
        self.update_lever(percept, step_s);
        if hangs {
            self.update_weight(down_n, finding.slips, step_s);
        }
    }

    fn update_lever(&mut self, percept: &Percept, step_s: f64) {
        let fingers = &percept.sides;
        let load_n = load_n(percept);
        if load_n < LOAD_MIN_N {
            return;
        }
        let share = step_s / (FILTER_S * (1.0 + LIGHT_LOAD_N / load_n) + step_s);
        // The fingertips face each other, so the moments about their normals have opposite signs.
        let signs = fingers.iter().zip([1.0, -1.0]);
        let moment_n_m: f64 = signs.map(|(f, sign)| sign * f.moment_n_m).sum();
        let beside_m = moment_n_m / load_n;
        self.lever_m += (beside_m.abs() - self.lever_m) * share;
        self.signed_lever_m += (beside_m - self.signed_lever_m) * share;
        let torsion = fingers.iter().map(|f| f.torsion).fold(0.0, larger);
        self.torsion += (torsion - self.torsion) * share;
        self.lever_max_m = larger(self.lever_max_m, self.lever_m);
        self.torsion_max = larger(self.torsion_max, self.torsion);
        self.turned_s = if self.has_turned() {
            self.turned_s + step_s
        } else {
            0.0
        };
    }

    fn has_turned(&self) -> bool {
        let turned = |[torsion, left]: &[f64; 2]| {
            self.torsion_max > *torsion && self.lever_m < left * self.lever_max_m
        };
        TURNING.iter().any(turned)
    }

    fn update_weight(&mut self, down_n: f64, slides: bool, step_s: f64) {
        if self.weight_n <= 0.0 {
            (self.weight_n, self.weighed_s) = (down_n.max(0.0), 0.0);
            return;
        }
        if slides || self.slip_m_s > 0.0 {
            // Noise and tremor would add up: the sliding speed is never negative.
            let missing_n = self.weight_n - down_n - libm::sqrt(self.scatter_n2);
            let missing = missing_n / self.weight_n;
            self.slip_m_s = (self.slip_m_s + GRAVITY_M_S2 * missing * step_s).max(0.0);
            self.slip_m += self.slip_m_s * step_s;
        } else {
            // Averages all samples at first: single readings of a light object are too noisy.
            self.weighed_s += step_s;
            let filter_s = self.weighed_s.min(WEIGHT_S);
            let off_n = down_n - self.weight_n;
            self.scatter_n2 = low_pass(self.scatter_n2, off_n * off_n, step_s, filter_s);
            self.weight_n = low_pass(self.weight_n, down_n, step_s, filter_s);
        }
        self.weight_max_n = larger(
            self.weight_max_n * WEIGHT_MAX_S / (WEIGHT_MAX_S + step_s),
            self.weight_n,
        );
        self.load_n = down_n.abs();
        self.loss_s = if self.load_n < LOSS_SHARE * self.weight_max_n {
            self.loss_s + step_s
        } else {
            0.0
        };
    }

    /// Returns the largest lever so far, m; positive 90° anticlockwise of the closing axis.
    pub(super) fn lever_m(&self) -> f64 {
        libm::copysign(self.lever_max_m, self.signed_lever_m)
    }

    /// Returns the reason if the object no longer loads the hand.
    pub(super) fn loss(&self) -> Option<Reason> {
        let least_n = LOSS_SHARE * self.weight_max_n;
        (self.loss_s > LOSS_S).then(|| Reason::with_limit(Cause::LOST_OBJECT, self.load_n, least_n))
    }

    /// Returns the reason if the completed task failed by slip or rotation.
    pub(super) fn failure(&self) -> Option<Reason> {
        if self.slip_m > SLIP_MAX_M {
            let reason = Reason::with_limit(Cause::SLIPPED_IN_HAND, self.slip_m, SLIP_MAX_M);
            return Some(reason);
        }
        self.has_turned().then(|| self.turned_reason())
    }

    /// Returns the reason if the object keeps rotating in the hand.
    pub(super) fn turning(&self) -> Option<Reason> {
        (self.turned_s > TURNING_S).then(|| self.turned_reason())
    }

    fn turned_reason(&self) -> Reason {
        Reason::with_limit(Cause::TURNED_IN_HAND, self.lever_m, self.lever_max_m)
    }
}

fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Regression: the weight of a bottle that slid out within two seconds fell too slowly to be
    /// detected.
    #[test]
    fn gradual_weight_loss_within_seconds_is_detected() {
        let percept = Percept {
            step_s: 1e-3,
            ..Percept::default()
        };
        let lost_after_ticks = |lighter_n_s: f64| {
            let mut in_hand = InHandMonitor::default();
            (0..5000).position(|tick| {
                let down_n = 5.0 - lighter_n_s * 1e-3 * f64::from(tick);
                let facts = (Finding::default(), true, true);
                in_hand.update(&percept, down_n.max(0.5), 0.01, facts);
                in_hand.loss().is_some()
            })
        };
        assert!(lost_after_ticks(2.0).is_some(), "5 N lost by sliding out");
        assert_eq!(lost_after_ticks(0.5), None, "half of the weight poured out");
    }

    /// Regression: without lift verification, the whole carried distance was reported as slip.
    #[test]
    fn carried_distance_is_slip_only_with_lift_verification() {
        let percept = Percept {
            step_s: 1e-3,
            ..Percept::default()
        };
        let slides = Finding {
            slips: true,
            ..Finding::default()
        };
        for is_tested in [false, true] {
            let mut in_hand = InHandMonitor::default();
            in_hand.update(&percept, 1.0, 0.010, (slides, false, is_tested));
            assert_eq!(in_hand.failure().is_some(), is_tested);
        }
    }
}
