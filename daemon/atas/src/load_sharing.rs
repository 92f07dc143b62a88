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
use robot_model::{FINGERTIPS_MAX, GraspPose, GraspSide, HandModel, HandPose, HandTarget, PerSide};

/// Closing speed of a fingertip without contact, m/s. Design choice: twice that of the first touch,
/// so that it arrives before the opposite side.
const CONTACT_SEARCH_M_S: f64 = 0.004;
/// Yielding speed per excess force, m/s per N. Design choice: on 3,000 N/m the difference vanishes
/// within 0.1 s, three frames of the slowest sensor.
const YIELDING_M_S_N: f64 = 0.003;
/// Largest offset along the closing axis, m. Design choice: covers fingertips 45 mm apart on a face
/// rotated by 15°.
const OFFSET_MAX_M: f64 = 0.006;

/// Offsets of the fingertips from their side's mean.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct LoadSharing {
    /// Offset inwards, m; the mean over a side is 0.
    offset_m: [f64; FINGERTIPS_MAX],
    /// Closing travel for bringing every fingertip into contact, m.
    contact_search_m: f64,
}

impl LoadSharing {
    /// Initialises the offsets from the hand's pose.
    pub(crate) fn new(hand: &HandModel, pose: &HandPose, frame: &GraspPose) -> Self {
        let mut sharing = Self::default();
        let n = frame.closing_axis();
        for side in shared_sides(hand) {
            let inwards = n * -side.outward();
            for finger in hand.fingertips_of(side) {
                let from_middle_m = pose.tip_m(finger) - pose.side_m(side);
                let ahead_m = from_middle_m.dot(&inwards);
                sharing.offset_m[finger] = ahead_m.clamp(-OFFSET_MAX_M, OFFSET_MAX_M);
            }
        }
        sharing
    }

    /// Returns the closing travel of the contact search, which adds no force, m.
    pub(crate) fn contact_search_m(&self) -> f64 {
        self.contact_search_m
    }

    /// Updates the offsets; returns the inward motion of each side's mean, m.
    pub(crate) fn update(
        &mut self,
        hand: &HandModel,
        percept: &Percept,
        step_s: f64,
    ) -> PerSide<f64> {
        let mut along_m = PerSide::repeat(0.0);
        for side in shared_sides(hand) {
            let touches = |finger: &usize| percept.fingertips[*finger].in_contact;
            if !hand.fingertips_of(side).any(|finger| touches(&finger)) {
                self.reduce_offsets(hand, side, CONTACT_SEARCH_M_S * step_s);
                continue;
            }
            let mean_n = hand.mean_of_side(side, |finger| percept.fingertips[finger].normal_n);
            for finger in hand.fingertips_of(side) {
                let ahead_m = &mut self.offset_m[finger];
                if touches(&finger) {
                    let more_n = percept.fingertips[finger].normal_n - mean_n;
                    *ahead_m -= YIELDING_M_S_N * more_n * step_s;
                } else if *ahead_m < OFFSET_MAX_M {
                    *ahead_m += CONTACT_SEARCH_M_S * step_s;
                }
                *ahead_m = ahead_m.clamp(-OFFSET_MAX_M, OFFSET_MAX_M);
            }
            along_m[side] = hand.mean_of_side(side, |finger| self.offset_m[finger]);
            for finger in hand.fingertips_of(side) {
                self.offset_m[finger] -= along_m[side];
            }
            self.contact_search_m += along_m[side];
        }
        along_m
    }

    /// Adds the offsets to the fingertip targets.
    pub(crate) fn apply_to(&self, hand: &HandModel, target: &mut HandTarget) {
        for side in shared_sides(hand) {
            for finger in hand.fingertips_of(side) {
                // The fingertip axis points inwards.
                target.tip_m[finger] += target.dome_axis[finger] * self.offset_m[finger];
            }
        }
    }

    fn reduce_offsets(&mut self, hand: &HandModel, side: GraspSide, by_m: f64) {
        let farthest_m = hand
            .fingertips_of(side)
            .map(|finger| self.offset_m[finger].abs())
            .fold(0.0, f64::max);
        let left = if farthest_m > by_m {
            1.0 - by_m / farthest_m
        } else {
            0.0
        };
        for finger in hand.fingertips_of(side) {
            self.offset_m[finger] *= left;
        }
    }
}

fn shared_sides(hand: &HandModel) -> impl Iterator<Item = GraspSide> + '_ {
    GraspSide::BOTH
        .into_iter()
        .filter(|side| hand.fingertips_of(*side).count() > 1)
}
