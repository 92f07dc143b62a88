//! Sharing: the fingertips that press from one side share what the side presses.
//!
//! A side closes as one. Where an object is turned, or round, one of its fingertips meets it first: the others go on by themselves
//! until each touches, and from then on every one gives way to what it presses more than the mean, as the bar of a whiffletree or
//! the differential of an underactuated hand does (Birglen, Laliberté and Gosselin 2008). In: what each fingertip feels. Out:
//! how far each is ahead of its side's middle, and how far the middle goes along.
//!
//! A side of one fingertip has nothing to share: nothing here touches its numbers.

use crate::perception::Percept;
use robot_model::{FINGERS_MAX, GraspFrame, HandModel, HandPose, HandTarget, VIRTUAL_FINGERS};

/// Speed at which a fingertip looks for what another of its side touches, m/s (ours: twice that of a first touch, so that
/// it has found it when the opposite side has).
const LOOK_M_S: f64 = 0.004;
/// Speed at which a fingertip gives way to what it presses more than its side's mean, m/s per newton (ours: on 3,000 N/m it is
/// gone within 0.1 s, three frames of the slowest sensor).
const GIVE_WAY_M_S_N: f64 = 0.003;
/// Farthest that a fingertip may be from its side's middle along the closing axis, m (ours: 45 mm between two fingertips on a face
/// that is turned by 15°).
const AHEAD_MAX_M: f64 = 0.006;

/// How far each fingertip is ahead of its side's middle.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Sharing {
    /// Inwards, m; the mean over a side is 0.
    ahead_m: [f64; FINGERS_MAX],
    /// How far both sides have closed for no more than finding the object with every fingertip, m.
    looked_m: f64,
}

impl Sharing {
    /// As the hand stands.
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

    /// How far both sides have closed without pressing harder for it, m.
    pub(crate) fn looked_m(&self) -> f64 {
        self.looked_m
    }

    /// One tick of `step_s`; returns how far the middle of each side goes along, inwards, m.
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
            // What is left of their mean moves the side.
            along_m[side] = hand.mean_of_side(side, |finger| self.ahead_m[finger]);
            for finger in hand.fingers_of(side) {
                self.ahead_m[finger] -= along_m[side];
            }
            self.looked_m += along_m[side];
        }
        along_m
    }

    /// Moves the targets of the fingertips to where each shall be.
    pub(crate) fn spread(&self, hand: &HandModel, target: &mut HandTarget) {
        for side in shared_sides(hand) {
            for finger in hand.fingers_of(side) {
                // A dome faces inwards.
                target.tip_m[finger] += target.dome_axis[finger] * self.ahead_m[finger];
            }
        }
    }

    /// Nothing is touched: back into line.
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

/// The sides from which more than one fingertip presses.
fn shared_sides(hand: &HandModel) -> impl Iterator<Item = usize> + '_ {
    (0..VIRTUAL_FINGERS).filter(|side| hand.fingers_of(*side).count() > 1)
}
