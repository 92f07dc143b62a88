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
mod tests {
    use super::*;

    /// Regression: the weight of a bottle that slid out within two seconds fell too slowly to be
    /// detected.
    #[test]
    fn gradual_weight_loss_within_seconds_is_detected() {
        let lost_after_ticks = |lighter_n_s: f64| {
            let mut weight = Weight::default();
            (0..5000).position(|tick| {
                let down_n = 5.0 - lighter_n_s * 1e-3 * f64::from(tick);
                weight.update(down_n.max(0.5), false, 1e-3);
                weight.loss().is_some()
            })
        };
        assert!(lost_after_ticks(2.0).is_some(), "5 N lost by sliding out");
        assert_eq!(lost_after_ticks(0.5), None, "half of the weight poured out");
    }

    /// Regression: a bottle slid slowly through the fingers down to the table, with uniform shear
    /// and without a sudden drop; the task succeeded.
    #[test]
    fn object_that_slides_to_its_support_is_not_carried() {
        for (remaining, is_carried) in [(1.0, true), (0.9, true), (0.4, false)] {
            let mut weight = Weight::default();
            for tick in 0..5000 {
                let share = (f64::from(tick - 1000) / 1000.0).clamp(0.0, 1.0);
                let down_n = 5.0 - 5.0 * (1.0 - remaining) * share;
                weight.update(down_n, false, 1e-3);
            }
            let reason = weight.lightening();
            assert_eq!(reason.is_none(), is_carried, "{remaining} of the weight");
        }
    }

    #[test]
    fn standing_object_slips_by_the_hand_travel() {
        let mut weight = Weight::default();
        for (carried_m, fails) in [(0.002, false), (0.0025, false), (0.003, true)] {
            weight.stands(carried_m);
            assert_eq!(weight.slip().is_some(), fails, "{carried_m} m");
        }
    }

    /// Weight of 5 N with a scatter of 0.2 N.
    fn known() -> Weight {
        Weight {
            weight_n: 5.0,
            weighed_s: 1.0,
            scatter_n2: 0.04,
            ..Weight::default()
        }
    }

    #[test]
    fn weight_is_the_mean_of_the_first_loads() {
        let mut weight = Weight::default();
        for (down_n, mean_n) in [(-1.0, 0.0), (4.0, 4.0), (6.0, 5.0), (8.0, 6.0), (2.0, 5.0)] {
            weight.update(down_n, false, 0.01);
            assert!((weight.weight_n - mean_n).abs() < 1e-12, "{weight:?}");
        }
        // Squared deviations from the mean before: 2², 3², 4², averaged in the same way.
        let scatter_n2 = (4.0 / 2.0 * 2.0 / 3.0 + 9.0 / 3.0) * 3.0 / 4.0 + 16.0 / 4.0;
        assert!((weight.scatter_n2 - scatter_n2).abs() < 1e-12, "{weight:?}");
    }

    #[test]
    fn missing_load_accelerates_the_object() {
        for (drops, speed_m_s, down_n, after_m_s, slip_m) in [
            (false, 0.0, 4.0, 0.0, 0.0),
            (true, 0.0, 4.0, 9.81 * 0.16 * 0.01, 9.81 * 0.16 * 1e-4),
            (
                false,
                0.5,
                4.0,
                0.5 + 9.81 * 0.16 * 0.01,
                0.005 + 9.81 * 0.16 * 1e-4,
            ),
            (
                true,
                0.5,
                6.0,
                0.5 - 9.81 * 0.24 * 0.01,
                0.005 - 9.81 * 0.24 * 1e-4,
            ),
            (true, 0.001, 9.0, 0.0, 0.0),
        ] {
            let mut weight = Weight {
                slip_m_s: speed_m_s,
                ..known()
            };
            weight.update(down_n, drops, 0.01);
            assert!((weight.slip_m_s - after_m_s).abs() < 1e-12, "{weight:?}");
            assert!((weight.slip_m - slip_m).abs() < 1e-12, "{weight:?}");
            assert_eq!(
                weight.weight_n == 5.0,
                drops || speed_m_s > 0.0,
                "{weight:?}"
            );
        }
    }

    #[test]
    fn object_is_lost_below_its_share_of_the_weight() {
        for (down_n, loss) in [
            (1.6, false),
            (1.5, false),
            (1.4, true),
            (-1.4, true),
            (-1.6, false),
        ] {
            let mut weight = known();
            let reason = Reason::LostObject {
                force_n: 1.4,
                limit_n: 1.5,
            };
            for is_late in [false, false, true] {
                weight.update(down_n, true, 0.1);
                let expected = (loss && is_late).then_some(reason);
                assert_eq!(weight.loss(), expected, "{down_n} N");
            }
        }
    }

    #[test]
    fn reasons_need_more_than_their_limits() {
        let least_n = CARRIED_SHARE * 4.0 - libm::sqrt(0.01);
        for (weight_n, is_light) in [(least_n, false), (least_n.next_down(), true), (3.2, true)] {
            let weight = Weight {
                weight_n,
                max_n: 4.0,
                scatter_n2: 0.01,
                ..Weight::default()
            };
            let reason = Reason::LostObject {
                force_n: weight_n,
                limit_n: least_n,
            };
            assert_eq!(weight.lightening(), is_light.then_some(reason));
        }
        for (slip_m, has_slipped) in [(SLIP_MAX_M, false), (0.003, true)] {
            let weight = Weight {
                slip_m,
                ..Weight::default()
            };
            let reason = Reason::SlippedInHand {
                slip_m,
                limit_m: SLIP_MAX_M,
            };
            assert_eq!(weight.slip(), has_slipped.then_some(reason));
        }
    }
}
