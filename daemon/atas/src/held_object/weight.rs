//! Weight of the carried object: detects slip and loss.
//!
//! * **Slip**: the missing load accelerates a suspended object; integrated twice, it gives the slip
//!   distance. A standing object slips by the hand travel.
//! * **Loss**: a lost object loads no fingertip, in neither direction, even if a drifting sensor
//!   still reports grip force. A weight does not change: at the end of a task, a smaller load means
//!   that the hand does not carry the object alone.

use crate::filter::{Dwell, low_pass};
use crate::limits::GRAVITY_M_S2;
use shm_schemas::Reason;

/// Slip beyond which a task fails, m (design choice: 3 mm minus the estimation error).
const SLIP_MAX_M: f64 = 0.0028;
/// Filter time constant of the weight, s (design choice).
const WEIGHT_S: f64 = 0.7;
/// Share of its weight below which an object counts as lost, and the minimum duration, s (design
/// choice).
const LOSS_SHARE: f64 = 0.3;
const LOSS_S: f64 = 0.2;
/// Share of its weight, less the scatter, that an object keeps until the task succeeds (design
/// choice: several times the error of the weight). An object that slides out to its support, or
/// that something else carries, loads the hand less.
const CARRIED_SHARE: f64 = 0.85;
/// Decay time constant of the maximum weight, s (design choice: longer than a lift).
const WEIGHT_MAX_S: f64 = 10.0;

/// Weight since the start of the lift.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Weight {
    /// Weight before any slip, N (0: unknown), and its measuring time, s.
    weight_n: f64,
    weighed_s: f64,
    /// Variance of the load around the weight, N².
    scatter_n2: f64,
    /// Slowly decaying maximum weight, N; detects objects that slide out slowly.
    max_n: f64,
    slip_m_s: f64,
    slip_m: f64,
    /// Carried distance at which the object was last found standing, m.
    stood_at_m: f64,
    lost: Dwell,
    /// Magnitude of the present vertical load, N.
    load_n: f64,
}

impl Weight {
    /// The object stands although the hand was lifted by `carried_m`, m: the hand slid along it.
    pub(super) fn stands(&mut self, carried_m: f64) {
        self.slip_m += (carried_m - self.stood_at_m).max(0.0);
        self.stood_at_m = carried_m;
    }

    /// Adds the vertical load of a suspended object, N, and the sensor time, s.
    pub(super) fn update(&mut self, down_n: f64, drops: bool, step_s: f64) {
        if self.weight_n <= 0.0 {
            (self.weight_n, self.weighed_s) = (down_n.max(0.0), 0.0);
            return;
        }
        if drops || self.slip_m_s > 0.0 {
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
        self.max_n = (self.max_n * WEIGHT_MAX_S / (WEIGHT_MAX_S + step_s)).max(self.weight_n);
        self.load_n = down_n.abs();
        let is_lost = self.load_n < LOSS_SHARE * self.max_n;
        self.lost.update(is_lost, step_s);
    }

    /// Returns the reason if the object no longer loads the hand.
    pub(super) fn loss(&self) -> Option<Reason> {
        let least_n = LOSS_SHARE * self.max_n;
        (self.lost.seconds() > LOSS_S).then_some(Reason::LostObject {
            force_n: self.load_n,
            limit_n: least_n,
        })
    }

    /// Returns the reason if the hand no longer carries the whole weight.
    pub(super) fn lightening(&self) -> Option<Reason> {
        let least_n = CARRIED_SHARE * self.max_n - libm::sqrt(self.scatter_n2);
        (self.weight_n < least_n).then_some(Reason::LostObject {
            force_n: self.weight_n,
            limit_n: least_n,
        })
    }

    /// Returns the reason if the object has slipped too far.
    pub(super) fn slip(&self) -> Option<Reason> {
        (self.slip_m > SLIP_MAX_M).then_some(Reason::SlippedInHand {
            slip_m: self.slip_m,
            limit_m: SLIP_MAX_M,
        })
    }
}

#[cfg(test)]
mod tests;
