//! Lever of the centre of mass: detects that the carried object rotates in the hand.
//!
//! An off-centre mass loads the fingertips with a moment about the closing axis. The lever (moment
//! over load) shrinks when the object rotates and its centre of mass swings below the grip.

use crate::filter::{Dwell, low_pass};
use crate::perception::Percept;
use shm_schemas::Reason;

/// Filter time constant of moment and lever, s (design choice: one period of hand tremor).
const FILTER_S: f64 = 0.05;
/// Total load below which noise requires a slower filter, N (design choice).
const LIGHT_LOAD_N: f64 = 0.3;
/// Minimum total load for a lever estimate, N (design choice: several times the sensor noise).
const LOAD_MIN_N: f64 = 0.05;
/// Vertical load, as a share of the grip force, below which the moment shows how the object stands
/// and how the faces are misaligned, not its lever (design choice: a tenth of a usual load).
const LOAD_SHARE_MIN: f64 = 0.03;
/// Pairs of minimum torsion ratio and maximum remaining lever share of a rotated object (design
/// choice, measured with centres of mass up to 5 mm off-centre).
const ROTATED: [[f64; 2]; 2] = [[0.6, 0.9], [0.5, 0.7]];
/// Minimum duration of a rotation, s (design choice: longer than one swing).
const ROTATING_S: f64 = 0.3;

/// Time since the maximum after which the lever no longer rises, s (design choice: the filter
/// time).
const PEAK_S: f64 = 0.05;

/// Lever since the start of the lift.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Lever {
    /// Filtered lever about the closing axis, m.
    now_m: f64,
    /// Signed lever, m: positive 90° anticlockwise of the closing axis, seen from above.
    signed_m: f64,
    torsion: f64,
    max_m: f64,
    torsion_max: f64,
    rotated: Dwell,
    /// The lever is below its maximum.
    past_max: Dwell,
}

impl Lever {
    /// Adds the frames of one tick, with the vertical load on the hand, N.
    pub(super) fn update(&mut self, percept: &Percept, down_n: f64) {
        let load_n = percept.total_tangential_n();
        let least_n = LOAD_SHARE_MIN * percept.total_normal_n();
        if load_n < LOAD_MIN_N || down_n < least_n {
            return;
        }
        let filter_s = FILTER_S * (1.0 + LIGHT_LOAD_N / load_n);
        let filter = |before, now| low_pass(before, now, percept.step_s, filter_s);
        // The sides face each other, so the moments about their normals have opposite signs.
        let [first, second] = percept.sides.each_ref().into_array();
        let lever_m = (first.moment_n_m - second.moment_n_m) / load_n;
        self.now_m = filter(self.now_m, lever_m.abs());
        self.signed_m = filter(self.signed_m, lever_m);
        self.torsion = filter(self.torsion, first.torsion.max(second.torsion));
        self.past_max
            .update(self.now_m < self.max_m, percept.step_s);
        self.max_m = self.max_m.max(self.now_m);
        self.torsion_max = self.torsion_max.max(self.torsion);
        self.rotated.update(self.has_rotated(), percept.step_s);
    }

    fn has_rotated(&self) -> bool {
        let rotated = |[torsion, remaining]: &[f64; 2]| {
            self.torsion_max > *torsion && self.now_m < remaining * self.max_m
        };
        ROTATED.iter().any(rotated)
    }

    /// Returns the largest lever so far, m; positive 90° anticlockwise of the closing axis.
    pub(super) fn max_m(&self) -> f64 {
        libm::copysign(self.max_m, self.signed_m)
    }

    /// Returns true if the lever has passed its maximum.
    pub(super) fn has_peaked(&self) -> bool {
        self.past_max.seconds() > PEAK_S
    }

    /// Returns the reason if the object has rotated.
    pub(super) fn rotation(&self) -> Option<Reason> {
        self.has_rotated().then(|| self.reason())
    }

    /// Returns the reason if the object keeps rotating.
    pub(super) fn turning(&self) -> Option<Reason> {
        (self.rotated.seconds() > ROTATING_S).then(|| self.reason())
    }

    fn reason(&self) -> Reason {
        Reason::TurnedInHand {
            lever_m: self.now_m,
            lever_before_m: self.max_m,
        }
    }
}

#[cfg(test)]
mod tests;
