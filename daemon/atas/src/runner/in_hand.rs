//! What has become of the object in the hand, as far as fingertips can tell: how far it slipped, whether it turned, and
//! whether it is still there. A task that ends without these answers would claim what nobody has looked at.
//!
//! * **Slip**: what falls accelerates by as much as the fingers carry too little; integrated twice that is a distance. What
//!   still stands slides by as much as the hand travels.
//! * **Turn**: an object whose centre of mass lies beside the grip loads both fingertips with a moment about the closing axis.
//!   While friction carries it, the lever (moment over weight) stays; an object that turns swings its centre of mass below
//!   the grip, and the lever gets shorter.
//! * **Loss**: what is gone has no weight, whatever a drifting sensor says of the grip.

use crate::filter::low_pass;
use crate::modules::{Finding, load_n};
use crate::perception::Percept;
use shm_schemas::{Cause, Reason};

/// Standard gravity, m/s².
const GRAVITY_M_S2: f64 = 9.81;
/// Slip beyond which a task has not succeeded, m (ours: 3 mm, less what the estimate may be wrong by).
const SLIP_MAX_M: f64 = 0.0028;
/// Time constant over which moment and lever are felt, s (ours: a period of a hand's tremble).
const FILTER_S: f64 = 0.05;
/// Load of both fingers below which they are felt for longer, because the sensors' noise counts more, N (ours).
const LIGHT_N: f64 = 0.3;
/// Time constant of the weight, s (ours).
const WEIGHT_S: f64 = 0.7;
/// Load of both fingers from which on a lever can be told, N (ours: several times the noise of two fingertips).
const LOAD_MIN_N: f64 = 0.05;
/// Share of the moment that friction could carry from which on an object may have turned, and the share of its lever that
/// then must be left (ours, measured on objects with their centre of mass up to 5 mm aside).
const TURNING: [[f64; 2]; 2] = [[0.6, 0.9], [0.5, 0.7]];
/// How long it must have felt so to be believed, s (ours: a swing of it is none).
const TURNED_S: f64 = 0.3;
/// Share of its weight below which an object is gone, and how long it must be, s (ours).
const GONE_SHARE: f64 = 0.3;
const GONE_S: f64 = 0.2;
/// Time constant with which the most that it has weighed is forgotten, s (ours: longer than a lift).
const MOST_S: f64 = 10.0;

/// One hold, from the beginning of the lift.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct InHand {
    /// Moment about the closing axis over load, m, and share of friction that it takes, low-passed; the most of each.
    lever_m: f64,
    /// The lever with its sign: positive where the weight hangs 90° anticlockwise of the closing axis, seen from above.
    beside_m: f64,
    torsion: f64,
    lever_most_m: f64,
    torsion_most: f64,
    /// How long it has felt as if it had turned, s.
    turned_s: f64,
    /// Weight as it was before anything fell, N; 0 while unknown. How long it has been felt, s.
    weight_n: f64,
    weighed_s: f64,
    /// The most that it has weighed, forgotten slowly, N: what slides away slowly gets lighter slowly.
    most_n: f64,
    falling_m_s: f64,
    slid_m: f64,
    /// How far the hand had carried it when a test found last that it still stands, m.
    stood_at_m: f64,
    gone_s: f64,
}

impl InHand {
    /// Takes in one tick: what the hand feels, the vertical load on it, N, how far it has carried, m, and what the modules
    /// have found out. Where no test tells whether it stands, nothing is known of how far it slides while it does.
    pub(super) fn follow(
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
        if finding.slides && !hangs && is_tested {
            self.slid_m += (carried_m - self.stood_at_m).max(0.0);
        }
        self.feel(percept, step_s);
        if hangs {
            self.weigh(down_n, finding.slides, step_s);
        }
    }

    fn feel(&mut self, percept: &Percept, step_s: f64) {
        let fingers = &percept.virtual_fingers;
        let load_n = load_n(percept);
        if load_n < LOAD_MIN_N {
            return;
        }
        let share = step_s / (FILTER_S * (1.0 + LIGHT_N / load_n) + step_s);
        // The fingertips face each other, so a moment about the closing axis has opposite signs about their normals.
        let signs = fingers.iter().zip([1.0, -1.0]);
        let moment_n_m: f64 = signs.map(|(f, sign)| sign * f.moment_n_m).sum();
        let beside_m = moment_n_m / load_n;
        self.lever_m += (beside_m.abs() - self.lever_m) * share;
        self.beside_m += (beside_m - self.beside_m) * share;
        let torsion = fingers.iter().map(|f| f.torsion).fold(0.0, larger);
        self.torsion += (torsion - self.torsion) * share;
        self.lever_most_m = larger(self.lever_most_m, self.lever_m);
        self.torsion_most = larger(self.torsion_most, self.torsion);
        self.turned_s = if self.has_turned() {
            self.turned_s + step_s
        } else {
            0.0
        };
    }

    fn has_turned(&self) -> bool {
        let turned = |[torsion, left]: &[f64; 2]| {
            self.torsion_most > *torsion && self.lever_m < left * self.lever_most_m
        };
        TURNING.iter().any(turned)
    }

    fn weigh(&mut self, down_n: f64, slides: bool, step_s: f64) {
        if self.weight_n <= 0.0 {
            (self.weight_n, self.weighed_s) = (down_n.max(0.0), 0.0);
            return;
        }
        let missing = 1.0 - down_n / self.weight_n;
        if slides || self.falling_m_s > 0.0 {
            self.falling_m_s = (self.falling_m_s + GRAVITY_M_S2 * missing * step_s).max(0.0);
            self.slid_m += self.falling_m_s * step_s;
        } else {
            // At first all that was felt counts alike: one reading of a light object tells little.
            self.weighed_s += step_s;
            let filter_s = self.weighed_s.min(WEIGHT_S);
            self.weight_n = low_pass(self.weight_n, down_n, step_s, filter_s);
        }
        self.most_n = larger(self.most_n * MOST_S / (MOST_S + step_s), self.weight_n);
        self.gone_s = if down_n < GONE_SHARE * self.most_n {
            self.gone_s + step_s
        } else {
            0.0
        };
    }

    /// How far beside the grip the object's weight hangs, at least, m: positive 90° anticlockwise of the closing axis.
    pub(super) fn lever_m(&self) -> f64 {
        libm::copysign(self.lever_most_m, self.beside_m)
    }

    /// Why the object is no longer in the hand, if so.
    pub(super) fn lost(&self) -> Option<Reason> {
        (self.gone_s > GONE_S)
            .then(|| Reason::limit(Cause::LOST_OBJECT, 0.0, GONE_SHARE * self.most_n))
    }

    /// Why the task has not succeeded although it came to its end.
    pub(super) fn objection(&self) -> Option<Reason> {
        if self.slid_m > SLIP_MAX_M {
            let reason = Reason::limit(Cause::SLIPPED_IN_HAND, self.slid_m, SLIP_MAX_M);
            return Some(reason);
        }
        self.has_turned().then(|| self.turn())
    }

    /// Why the object, which goes on turning in the hand, is to be carried no further.
    pub(super) fn turned(&self) -> Option<Reason> {
        (self.turned_s > TURNED_S).then(|| self.turn())
    }

    fn turn(&self) -> Reason {
        Reason::limit(Cause::TURNED_IN_HAND, self.lever_m, self.lever_most_m)
    }
}

fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Regression: a bottle that slid out of the hand within two seconds got lighter so slowly that it was not missed.
    #[test]
    fn what_gets_lighter_within_seconds_is_lost() {
        let percept = Percept {
            step_s: 1e-3,
            ..Percept::default()
        };
        let lost_after_ticks = |lighter_n_s: f64| {
            let mut in_hand = InHand::default();
            (0..5000).position(|tick| {
                let down_n = 5.0 - lighter_n_s * 1e-3 * f64::from(tick);
                let facts = (Finding::default(), true, true);
                in_hand.follow(&percept, down_n.max(0.5), 0.01, facts);
                in_hand.lost().is_some()
            })
        };
        assert!(lost_after_ticks(2.0).is_some(), "5 N that slide away");
        assert_eq!(lost_after_ticks(0.5), None, "half of it poured out");
    }

    /// Regression: an object that a task without a load test had set down again had slipped, it was said, by the whole way
    /// that the hand had carried it.
    #[test]
    fn without_a_test_nothing_has_slipped_by_the_way_it_was_carried() {
        let percept = Percept {
            step_s: 1e-3,
            ..Percept::default()
        };
        let slides = Finding {
            slides: true,
            ..Finding::default()
        };
        for is_tested in [false, true] {
            let mut in_hand = InHand::default();
            in_hand.follow(&percept, 1.0, 0.010, (slides, false, is_tested));
            assert_eq!(in_hand.objection().is_some(), is_tested);
        }
    }
}
