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
mod tests {
    use super::*;
    use crate::perception::ContactPercept;

    /// Frames of 1 ms with these moments, N·m, tangential forces, N, and torsion ratios. Without
    /// grip force, any vertical load counts.
    fn frame(moments_n_m: [f64; 2], tangential_n: [f64; 2], torsion: [f64; 2]) -> Percept {
        let side = |side: usize| ContactPercept {
            moment_n_m: moments_n_m[side],
            tangential_n: tangential_n[side],
            torsion: torsion[side],
            ..ContactPercept::default()
        };
        Percept {
            sides: [side(0), side(1)].into(),
            step_s: 1e-3,
            ..Percept::default()
        }
    }

    fn lever_after(ticks: usize, percept: &Percept) -> Lever {
        let mut lever = Lever::default();
        for _ in 0..ticks {
            lever.update(percept, percept.total_tangential_n());
        }
        lever
    }

    /// Regression: a block gripped by misaligned fingertips was put back four times and grasped
    /// ever farther from its centre, because the moment of the standing block counted as its lever.
    #[test]
    fn moment_of_a_standing_object_is_no_lever() {
        let mut percept = frame([0.002, -0.002], [0.4; 2], [0.0; 2]);
        for side in percept.sides.iter_mut() {
            side.normal_n = 4.0;
        }
        for (down_n, lever_m) in [(0.1, 0.0), (0.8, 0.005)] {
            let mut lever = Lever::default();
            for _ in 0..1000 {
                lever.update(&percept, down_n);
            }
            let found_m = lever.max_m();
            assert!((found_m - lever_m).abs() < 1e-4, "{down_n} N: {found_m} m");
        }
    }

    #[test]
    fn lever_needs_a_vertical_load_in_proportion_to_the_grip() {
        // Grip force per side, and vertical load, N.
        for (normal_n, down_n, counts) in [
            (4.0, 0.24, true),
            (4.0, 0.24_f64.next_down(), false),
            (2.0, 0.12, true),
            (2.0, 0.12_f64.next_down(), false),
            (4.0, 0.0, false),
            (4.0, -2.0, false),
            (0.0, 0.0, true),
        ] {
            let mut percept = frame([0.01, 0.0], [1.0; 2], [0.7; 2]);
            for side in percept.sides.iter_mut() {
                side.normal_n = normal_n;
            }
            let mut lever = Lever::default();
            lever.update(&percept, down_n);
            let found = (lever.max_m() > 0.0, lever.torsion_max > 0.0);
            assert_eq!(found, (counts, counts), "{down_n} N at {normal_n} N");
        }
    }

    #[test]
    fn lever_approaches_moment_over_load() {
        for (moments_n_m, tangential_n, lever_m, filter_s) in [
            ([0.01, -0.002], [1.0, 1.0], 0.006, 0.0575),
            ([-0.01, 0.002], [1.0, 1.0], -0.006, 0.0575),
            ([0.003, 0.001], [0.1, 0.2], 0.02 / 3.0, 0.1),
            ([0.001, 0.0], [0.025, 0.025], 0.02, 0.35),
            ([0.001, 0.0], [0.025, 0.024], 0.0, 0.35),
        ] {
            let lever = lever_after(30, &frame(moments_n_m, tangential_n, [0.3, 0.4]));
            let share = 1.0 - (filter_s / (filter_s + 1e-3_f64)).powi(30);
            let expected_m = lever_m * share;
            assert!((lever.max_m() - expected_m).abs() < 1e-12, "{lever:?}");
            let torsion = if lever_m == 0.0 { 0.0 } else { 0.4 * share };
            assert!((lever.torsion_max - torsion).abs() < 1e-12, "{lever:?}");
            assert!(!lever.has_peaked() && lever.turning().is_none());
        }
    }

    #[test]
    fn lever_has_peaked_once_it_shrinks_for_the_filter_time() {
        let (large, none) = ([0.01, 0.0], [0.0; 2]);
        let mut lever = lever_after(100, &frame(large, [1.0; 2], [0.0; 2]));
        let max_m = lever.max_m();
        let shrinks = Percept {
            step_s: 0.025,
            ..frame(none, [1.0; 2], [0.0; 2])
        };
        // The first frame shrinks the lever, and counts.
        for has_peaked in [false, false, true] {
            lever.update(&shrinks, 2.0);
            assert_eq!((lever.has_peaked(), lever.max_m()), (has_peaked, max_m));
        }
        let centred = lever_after(200, &frame(none, [1.0; 2], [0.0; 2]));
        assert!(!centred.has_peaked(), "no lever, no maximum");
    }

    #[test]
    fn object_has_rotated_with_torsion_and_smaller_lever() {
        // Remaining share of a lever of 0.5 m.
        for (torsion_max, remaining, has_rotated) in [
            (0.7, 0.8, true),
            (0.7, 0.9, false),
            (0.6, 0.8, false),
            (0.6, 0.6, true),
            (0.6, 0.7, false),
            (0.55, 0.8, false),
            (0.55, 0.6, true),
            (0.5, 0.1, false),
            (0.5_f64.next_up(), 0.1, true),
        ] {
            let lever = Lever {
                torsion_max,
                now_m: remaining / 2.0,
                max_m: 0.5,
                ..Lever::default()
            };
            let reason = Reason::TurnedInHand {
                lever_m: remaining / 2.0,
                lever_before_m: 0.5,
            };
            let expected = has_rotated.then_some(reason);
            assert_eq!(lever.rotation(), expected, "{torsion_max}, {remaining}");
        }
    }

    #[test]
    fn object_turns_after_a_rotation_longer_than_a_swing() {
        let mut lever = Lever {
            torsion_max: 0.7,
            now_m: 0.5,
            max_m: 1.0,
            ..Lever::default()
        };
        let still = Percept {
            step_s: 0.15,
            ..frame([0.0; 2], [1.0; 2], [0.0; 2])
        };
        for turns in [false, false, true] {
            lever.update(&still, 2.0);
            assert_eq!(lever.turning().is_some(), turns, "{lever:?}");
        }
        let reason = Reason::TurnedInHand {
            lever_m: lever.now_m,
            lever_before_m: 1.0,
        };
        assert_eq!(lever.turning(), Some(reason));
    }
}
