//! Load sharing between the fingertips of one grasp side.
//!
//! On a rotated or round object one fingertip touches first. The others close until all are in
//! contact. Then each yields in proportion to its force above the mean, like a whiffletree or an
//! underactuated hand's differential (Birglen, Laliberté and Gosselin 2008).
//!
//! * **Input:** contact and force per fingertip. **Output:** offset per fingertip from its side's
//!   mean, motion of that mean.
//! * Sides with one fingertip are unaffected.

use crate::perception::Percept;
use robot_model::{FINGERS_MAX, GraspFrame, HandModel, HandPose, HandTarget, VIRTUAL_FINGERS};

/// Closing speed of a fingertip without contact, m/s. Design choice: twice that of the first touch,
/// so that it arrives before the opposite side.
const LOOK_M_S: f64 = 0.004;
/// Yielding speed per excess force, m/s per N. Design choice: on 3,000 N/m the difference vanishes
/// within 0.1 s, three frames of the slowest sensor.
const GIVE_WAY_M_S_N: f64 = 0.003;
/// Largest offset along the closing axis, m. Design choice: covers fingertips 45 mm apart on a face
/// rotated by 15°.
const AHEAD_MAX_M: f64 = 0.006;

/// Offsets of the fingertips from their side's mean.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Sharing {
    /// Offset inwards, m; the mean over a side is 0.
    ahead_m: [f64; FINGERS_MAX],
    /// Closing travel for bringing every fingertip into contact, m.
    looked_m: f64,
}

impl Sharing {
    /// Initialises the offsets from the hand's pose.
    pub(crate) fn at(hand: &HandModel, pose: &HandPose, frame: &GraspFrame) -> Self {
        let mut sharing = Self::default();
        let n = frame.closing_axis();
        for side in shared_sides(hand) {
            let inwards = if side == 0 { -n } else { n };
            for finger in hand.fingers_of(side) {
                let from_middle_m = pose.tip_m(finger) - pose.side_m(side);
                let ahead_m = from_middle_m.dot(&inwards);
                sharing.ahead_m[finger] = ahead_m.clamp(-AHEAD_MAX_M, AHEAD_MAX_M);
            }
        }
        sharing
    }

    /// Returns the closing travel of the contact search, which adds no force, m.
    pub(crate) fn looked_m(&self) -> f64 {
        self.looked_m
    }

    /// Updates the offsets; returns the inward motion of each side's mean, m.
    pub(crate) fn step(
        &mut self,
        hand: &HandModel,
        percept: &Percept,
        step_s: f64,
    ) -> [f64; VIRTUAL_FINGERS] {
        let mut along_m = [0.0; VIRTUAL_FINGERS];
        for side in shared_sides(hand) {
            let touches = |finger: &usize| percept.fingers[*finger].in_contact;
            if !hand.fingers_of(side).any(|finger| touches(&finger)) {
                self.straighten(hand, side, LOOK_M_S * step_s);
                continue;
            }
            let mean_n = hand.mean_of_side(side, |finger| percept.fingers[finger].normal_n);
            for finger in hand.fingers_of(side) {
                let ahead_m = &mut self.ahead_m[finger];
                if touches(&finger) {
                    let more_n = percept.fingers[finger].normal_n - mean_n;
                    *ahead_m -= GIVE_WAY_M_S_N * more_n * step_s;
                } else if *ahead_m < AHEAD_MAX_M {
                    *ahead_m += LOOK_M_S * step_s;
                }
                *ahead_m = ahead_m.clamp(-AHEAD_MAX_M, AHEAD_MAX_M);
            }
            along_m[side] = hand.mean_of_side(side, |finger| self.ahead_m[finger]);
            for finger in hand.fingers_of(side) {
                self.ahead_m[finger] -= along_m[side];
            }
            self.looked_m += along_m[side];
        }
        along_m
    }

    /// Adds the offsets to the fingertip targets.
    pub(crate) fn spread(&self, hand: &HandModel, target: &mut HandTarget) {
        for side in shared_sides(hand) {
            for finger in hand.fingers_of(side) {
                // The fingertip axis points inwards.
                target.tip_m[finger] += target.dome_axis[finger] * self.ahead_m[finger];
            }
        }
    }

    fn straighten(&mut self, hand: &HandModel, side: usize, by_m: f64) {
        let farthest_m = hand
            .fingers_of(side)
            .map(|finger| self.ahead_m[finger].abs())
            .fold(0.0, f64::max);
        let left = if farthest_m > by_m {
            1.0 - by_m / farthest_m
        } else {
            0.0
        };
        for finger in hand.fingers_of(side) {
            self.ahead_m[finger] *= left;
        }
    }
}

fn shared_sides(hand: &HandModel) -> impl Iterator<Item = usize> + '_ {
    (0..VIRTUAL_FINGERS).filter(|side| hand.fingers_of(*side).count() > 1)
}
