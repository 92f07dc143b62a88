//! Kinematics: from one hand's intent to joint positions. Intent in, [`HandCommand`] out; one inverse-kinematics step
//! per tick, warm-started on what was last commanded.
//!
//! Squeezing bends the fingers and moves the tips up or down by more than the rim of a patch can bear without slipping;
//! the known compliance C = J·K⁻¹·Jᵀ is corrected ahead: z −= (C·F)_z.

use crate::arbitration::Intent;
use crate::limits::{
    COMPLIANCE_FILTER_S, COMPLIANCE_MAX_M, SECONDARY_BUILD_UP_S, SECONDARY_STEP_S,
    SECONDARY_STEPS_MAX,
};
use crate::perception::Percept;
use crate::sharing::Sharing;
use nalgebra::{Vector2, Vector3};
use robot_model::{
    FINGERS_MAX, GraspFrame, HandJacobian, HandModel, HandPose, HandVector, IkStatus, IkWeights,
    VIRTUAL_FINGERS,
};

/// How far the wanted opening of a finger may be ahead of what its joints were allowed, m (ours: ten times what a finger that
/// closes at 2 mm/s and conveys at 50 mm/s lags behind).
const AHEAD_MAX_M: f64 = 0.0005;

/// How far the hand may be asked to shift between its fingers beyond what it does, m (ours: half of the above and a little more, so
/// that one finger that is held back alone is not taken for a hand that cannot shift).
const SHIFT_AHEAD_MAX_M: f64 = 0.0003;

/// Joint positions that kinematics asks for, before the safety gate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandCommand {
    /// Wanted positions, rad. May be anything; the gate checks.
    pub(crate) q_rad: HandVector,
    /// Closing speed of each virtual finger, m/s: the one that it is asked for or the one that its joints will have, whichever closes
    /// more.
    pub(crate) closing_m_s: [f64; VIRTUAL_FINGERS],
}

impl HandCommand {
    /// Wanted positions of one hand, rad, and the closing speed they stand for, m/s.
    #[must_use]
    pub fn new(q_rad: HandVector, closing_m_s: [f64; VIRTUAL_FINGERS]) -> Self {
        Self { q_rad, closing_m_s }
    }

    /// Closing speed of each virtual finger, m/s: negative only if it is asked to open and its joints open it.
    #[must_use]
    pub fn closing_m_s(&self) -> [f64; VIRTUAL_FINGERS] {
        self.closing_m_s
    }
}

/// The commanded pose of one hand.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HandServo {
    frame: GraspFrame,
    q_rad: HandVector,
    /// Low-passed force of the squeeze: the mean over the virtual fingers, N.
    squeeze_n: f64,
    /// Share of the secondary gain that has built up since the hand was anchored, 0 to 1.
    secondary: f64,
    sharing: Sharing,
}

impl HandServo {
    /// A hand that stands at these joint positions, rad.
    #[must_use]
    pub fn at(hand: &HandModel, q_rad: HandVector) -> Self {
        let pose = hand.forward(&q_rad);
        let frame = frame_of(hand, &pose);
        Self {
            sharing: Sharing::at(hand, &pose, &frame),
            frame,
            q_rad,
            squeeze_n: 0.0,
            secondary: 0.0,
        }
    }

    /// How far the hand has closed only so that every fingertip touches, m: no closing that presses.
    #[must_use]
    pub fn looked_m(&self) -> f64 {
        self.sharing.looked_m()
    }

    /// The closing axis as the hand stands, base frame, unit length: that of the pose, turned by what the wrist does for the
    /// fingertips.
    #[must_use]
    pub fn closing_axis(&self, hand: &HandModel) -> Vector3<f64> {
        self.frame.as_done_by(hand).closing_axis()
    }

    /// The commanded pose, without the compliance correction.
    #[must_use]
    pub fn frame(&self) -> &GraspFrame {
        &self.frame
    }

    /// What was last wanted and let through, rad.
    #[must_use]
    pub fn q_rad(&self) -> &HandVector {
        &self.q_rad
    }

    /// The joints stand as they do because the hand grips: the correction of what the grip bends is in them already.
    pub fn take_grip(&mut self, hand: &HandModel, percept: &Percept) {
        let (pose, n) = (hand.forward(&self.q_rad), self.closing_axis(hand));
        let jacobian = hand.jacobian(&pose);
        self.squeeze_n = mean_normal_n(percept);
        let bend_m = self.bend_m(hand, (&pose, &jacobian, &n), percept, 0.0);
        for (up_m, bend_m) in self.frame.up_m.iter_mut().zip(bend_m) {
            *up_m += bend_m.clamp(-COMPLIANCE_MAX_M, COMPLIANCE_MAX_M);
        }
    }

    /// Takes over what the safety gate let through of the wish, before it smoothed it: where it refuses, the next wish begins at
    /// what is commanded; where the joints only lag, at the wish. Begun at joints that lag, each wish would make up for the
    /// whole lag at once, and the hand would swing about its path.
    pub fn adopt(&mut self, q_rad: HandVector) {
        self.q_rad = q_rad;
    }

    /// Keeps still.
    #[must_use]
    pub fn rest(&self) -> HandCommand {
        HandCommand {
            q_rad: self.q_rad,
            closing_m_s: [0.0; VIRTUAL_FINGERS],
        }
    }

    /// One step towards the intent.
    pub fn follow(
        &mut self,
        hand: &HandModel,
        intent: &Intent,
        percept: &Percept,
        step_s: f64,
    ) -> HandCommand {
        let mut closing_m_s = self.integrate(intent, step_s);
        let (pose, n) = (hand.forward(&self.q_rad), self.closing_axis(hand));
        if intent.pose.is_none_or(|carried| !carried.with_fingers) {
            self.unwind(hand, &pose, &n);
            let along_m = self.sharing.step(hand, percept, step_s);
            for (side, along_m) in along_m.into_iter().enumerate() {
                if along_m != 0.0 {
                    self.frame.half_opening_m[side] -= along_m;
                    closing_m_s[side] += along_m / step_s;
                }
            }
        }
        let jacobian = hand.jacobian(&pose);
        let mut corrected = self.frame;
        let bend_m = self.bend_m(hand, (&pose, &jacobian, &n), percept, step_s);
        for (up_m, bend_m) in corrected.up_m.iter_mut().zip(bend_m) {
            *up_m -= bend_m.clamp(-COMPLIANCE_MAX_M, COMPLIANCE_MAX_M);
        }
        let weights = self.weights(step_s);
        let mut target = corrected.target(hand);
        self.sharing.spread(hand, &mut target);
        let step = hand.ik_step(&pose, &jacobian, &target, step_s, &weights);
        let q_rad = if step.status == IkStatus::Failed {
            self.q_rad
        } else {
            step.q_rad
        };
        let by_joints_m = closed_m(hand, &jacobian, &(q_rad - self.q_rad), &n);
        for (closing_m_s, by_joints_m) in closing_m_s.iter_mut().zip(by_joints_m) {
            *closing_m_s = closing_m_s.max(by_joints_m / step_s);
        }
        HandCommand { q_rad, closing_m_s }
    }

    /// How far the present grip bends the surface of each dome upwards where it touches, m: J·K⁻¹·Jᵀ·F over both fingers
    /// at once, because their forces cancel in the arm. Bending also turns the domes, and a turned dome drags its
    /// surface along: most of the effect. What one finger presses more than the other is not grip but sways the object, and
    /// to answer that would feed the swaying.
    fn bend_m(
        &mut self,
        hand: &HandModel,
        (pose, jacobian, n): (&HandPose, &HandJacobian, &Vector3<f64>),
        percept: &Percept,
        step_s: f64,
    ) -> [f64; VIRTUAL_FINGERS] {
        let share = step_s / (COMPLIANCE_FILTER_S + step_s);
        self.squeeze_n += (mean_normal_n(percept) - self.squeeze_n) * share;
        // The first side is pressed along +n, the second along −n, each fingertip with its share.
        let mut force_n = [Vector3::zeros(); FINGERS_MAX];
        for side in 0..VIRTUAL_FINGERS {
            let share_n = self.squeeze_n / hand.fingers_of(side).count() as f64;
            for finger in hand.fingers_of(side) {
                force_n[finger] = n * if side == 0 { share_n } else { -share_n };
            }
        }
        let stiffness_n_m_rad = hand.stiffness_n_m_rad();
        let bent_rad = jacobian
            .torques_n_m(&force_n)
            .zip_map(&stiffness_n_m_rad, |torque_n_m, k| torque_n_m / k);
        let bend_m = |finger: usize| {
            let moved_m = HandJacobian::moved(&jacobian.tips[finger].position, &bent_rad);
            let arm_m = pose.dome_axis(finger) * hand.tip_radius_m()[finger];
            let turned_rad = HandJacobian::moved(&jacobian.tips[finger].angular, &bent_rad);
            moved_m.z + turned_rad.cross(&arm_m).z
        };
        core::array::from_fn(|side| hand.mean_of_side(side, bend_m))
    }

    /// The posture in which a hand is found need not be the one that inverse kinematics prefers. The pull towards that
    /// one builds up slowly, else the first tick would jump.
    fn weights(&mut self, step_s: f64) -> IkWeights {
        self.secondary = (self.secondary + step_s / SECONDARY_BUILD_UP_S).min(1.0);
        let step_share = (step_s / SECONDARY_STEP_S).min(SECONDARY_STEPS_MAX);
        let gain = IkWeights::TICK.secondary_gain * step_share * self.secondary;
        IkWeights {
            secondary_gain: gain,
            ..IkWeights::TICK
        }
    }

    /// What the joints do not follow must not pile up: the wish to close while the gate lets no finger close would have to be
    /// undone before the hand opens, and the wish to close one finger alone, of a hand that can neither do that nor shift,
    /// would keep it from closing both.
    fn unwind(&mut self, hand: &HandModel, pose: &HandPose, n: &Vector3<f64>) {
        let radius_m = hand.tip_radius_m();
        let is_m: [f64; VIRTUAL_FINGERS] = core::array::from_fn(|finger| {
            let sign = if finger == 0 { 1.0 } else { -1.0 };
            let from_centre_m = pose.side_m(finger) - self.frame.centre_m;
            let radius_m = hand.mean_of_side(finger, |tip| radius_m[tip]);
            sign * from_centre_m.dot(n) - radius_m
        });
        let half_opening_m = &mut self.frame.half_opening_m;
        let shift_m = (half_opening_m[0] - is_m[0] - (half_opening_m[1] - is_m[1])) / 2.0;
        let beyond_m = shift_m - shift_m.clamp(-SHIFT_AHEAD_MAX_M, SHIFT_AHEAD_MAX_M);
        if beyond_m != 0.0 {
            half_opening_m[0] -= beyond_m;
            half_opening_m[1] += beyond_m;
        }
        for (half_opening_m, is_m) in half_opening_m.iter_mut().zip(is_m) {
            let least_m = is_m - AHEAD_MAX_M;
            if *half_opening_m < least_m {
                *half_opening_m = least_m;
            }
        }
    }

    /// Moves the commanded pose; returns the closing speed it stands for.
    fn integrate(&mut self, intent: &Intent, step_s: f64) -> [f64; VIRTUAL_FINGERS] {
        let before_m = self.frame.half_opening_m;
        let carried_fingers = match intent.pose {
            Some(carried) => {
                self.frame = carried.frame;
                carried.with_fingers
            }
            None => false,
        };
        if !carried_fingers {
            self.frame.half_opening_m =
                core::array::from_fn(|f| before_m[f] - intent.closing_m_s[f] * step_s);
        }
        core::array::from_fn(|f| (before_m[f] - self.frame.half_opening_m[f]) / step_s)
    }
}

/// How far the joints of each side's fingers move its tips towards the other side, along the closing axis n, m. What the arm does is no
/// closing: but where fingers share a drive, one can be closed by what the other is asked for.
fn closed_m(
    hand: &HandModel,
    jacobian: &HandJacobian,
    dq_rad: &HandVector,
    n: &Vector3<f64>,
) -> [f64; VIRTUAL_FINGERS] {
    let mut fingers_rad = *dq_rad;
    fingers_rad[hand.arm_joints()].fill(0.0);
    core::array::from_fn(|side| {
        let inwards = if side == 0 { -n } else { *n };
        hand.mean_of_side(side, |finger| {
            HandJacobian::moved(&jacobian.tips[finger].position, &fingers_rad).dot(&inwards)
        })
    })
}

/// Normal force of the squeeze, N: the mean over the virtual fingers.
fn mean_normal_n(percept: &Percept) -> f64 {
    let fingers = percept.virtual_fingers.iter();
    fingers.map(|f| f.normal_n).sum::<f64>() / VIRTUAL_FINGERS as f64
}

/// Distance between the middles of both sides' tips, m: what the measured closing is made of.
#[must_use]
pub fn gap_m(pose: &HandPose) -> f64 {
    (pose.side_m(0) - pose.side_m(1)).norm()
}

/// The grasp pose in which a hand stands.
#[must_use]
pub fn frame_of(hand: &HandModel, pose: &HandPose) -> GraspFrame {
    let (tip1_m, tip2_m) = (pose.side_m(0), pose.side_m(1));
    let centre_m = (tip1_m + tip2_m) / 2.0;
    let across = Vector2::new(tip1_m.x - tip2_m.x, tip1_m.y - tip2_m.y);
    let axis = pose.hand_axis();
    let radius_m = hand.tip_radius_m();
    let half_m = across.norm() / 2.0;
    let q_rad = pose.q_rad();
    GraspFrame {
        centre_m,
        closing_yaw_rad: unwound_yaw_rad(hand, q_rad, &centre_m, libm::atan2(across.y, across.x)),
        hand_azimuth_rad: hand.bearing_rad(&centre_m),
        hand_pitch_rad: libm::atan2(-axis.z, Vector3::new(axis.x, axis.y, 0.0).norm()),
        root_rad: hand.root_rad(q_rad),
        half_opening_m: core::array::from_fn(|side| {
            half_m - hand.mean_of_side(side, |finger| radius_m[finger])
        }),
        tangential_m: [0.0; VIRTUAL_FINGERS],
        up_m: [tip1_m.z - centre_m.z, tip2_m.z - centre_m.z],
    }
}

/// The measured yaw, unwound so that it agrees with the wrist's actual turn.
fn unwound_yaw_rad(
    hand: &HandModel,
    q_rad: &HandVector,
    centre_m: &Vector3<f64>,
    yaw_rad: f64,
) -> f64 {
    use core::f64::consts::TAU;
    let by_wrist = hand.yaw_of_joints_rad(q_rad, centre_m);
    yaw_rad + TAU * libm::round((by_wrist - yaw_rad) / TAU)
}
