//! Kinematics of one hand: [`Intent`] in, [`HandCommand`] out. One inverse-kinematics step per
//! tick, warm-started at the last command.
//!
//! Grip force bends the fingers and shifts the fingertips vertically, by more than the rim of a
//! contact patch tolerates without slip. The feed-forward correction is z −= (C·F)_z with the
//! compliance C = J·K⁻¹·Jᵀ.

use crate::arbitration::Intent;
use crate::limits::{
    COMPLIANCE_FILTER_S, COMPLIANCE_MAX_M, SECONDARY_BUILD_UP_S, SECONDARY_STEP_S,
    SECONDARY_STEPS_MAX,
};
use crate::load_sharing::LoadSharing;
use crate::perception::Percept;
use nalgebra::{Vector2, Vector3};
use robot_model::{
    FINGERTIPS_MAX, GraspPose, GraspSide, HandJacobian, HandModel, HandPose, HandVector, IkStatus,
    IkWeights, PerSide,
};

/// Largest lead of a side's commanded over its actual opening, m. Derivation: ten times the lag at
/// 2 mm/s closing and 50 mm/s transport.
const OPENING_LEAD_MAX_M: f64 = 0.0005;

/// Largest lead of the commanded over the actual shift between the sides, m. Design choice:
/// slightly above half of `OPENING_LEAD_MAX_M`, so that one blocked side does not count as a hand
/// that cannot shift.
const SHIFT_LEAD_MAX_M: f64 = 0.0003;

/// Joint positions from kinematics, before the safety gate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandCommand {
    /// Requested positions, rad or m; unchecked.
    pub(crate) q: HandVector,
    /// Closing speed per grasp side, m/s: maximum of the requested speed and that of the joints.
    pub(crate) closing_m_s: PerSide<f64>,
}

impl HandCommand {
    /// Creates a command from requested positions, rad or m, and closing speed per grasp side, m/s.
    #[must_use]
    pub fn new(q: HandVector, closing_m_s: PerSide<f64>) -> Self {
        Self { q, closing_m_s }
    }

    /// Returns the closing speed per grasp side, m/s; negative only if request and joint motion
    /// both open.
    #[must_use]
    pub fn closing_m_s(&self) -> PerSide<f64> {
        self.closing_m_s
    }
}

/// Commanded pose of one hand.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HandServo {
    pose: GraspPose,
    q: HandVector,
    /// Low-passed mean grip force of the sides, N.
    grip_force_n: f64,
    /// Share of the secondary gain since synchronisation, 0 to 1.
    secondary: f64,
    load_sharing: LoadSharing,
}

impl HandServo {
    /// Creates a servo at these joint positions, rad or m.
    #[must_use]
    pub fn new(hand: &HandModel, q: HandVector) -> Self {
        let pose = hand.forward(&q);
        let frame = grasp_pose(hand, &pose);
        Self {
            load_sharing: LoadSharing::new(hand, &pose, &frame),
            pose: frame,
            q,
            grip_force_n: 0.0,
            secondary: 0.0,
        }
    }

    /// Returns the closing travel that brought every fingertip into contact, m; it adds no grip
    /// force.
    #[must_use]
    pub fn contact_search_m(&self) -> f64 {
        self.load_sharing.contact_search_m()
    }

    /// Returns the present closing axis, base frame, unit length, including the wrist's rotation
    /// for the fingertips.
    #[must_use]
    pub fn closing_axis(&self, hand: &HandModel) -> Vector3<f64> {
        self.pose.executed_by(hand).closing_axis()
    }

    /// Returns the commanded pose, without the compliance correction.
    #[must_use]
    pub fn pose(&self) -> &GraspPose {
        &self.pose
    }

    /// Returns the last accepted request, rad or m.
    #[must_use]
    pub fn q(&self) -> &HandVector {
        &self.q
    }

    /// Initialises the correction from an existing grip, whose bending the joint positions already
    /// include.
    pub fn initialise_grip(&mut self, hand: &HandModel, percept: &Percept) {
        let (pose, n) = (hand.forward(&self.q), self.closing_axis(hand));
        let jacobian = hand.jacobian(&pose);
        self.grip_force_n = percept.mean_normal_n();
        let bend_m = self.grip_bending_m(hand, (&pose, &jacobian, &n), percept, 0.0);
        for (up_m, bend_m) in self.pose.up_m.iter_mut().zip(bend_m) {
            *up_m += bend_m.clamp(-COMPLIANCE_MAX_M, COMPLIANCE_MAX_M);
        }
    }

    /// Takes over the request that the gate accepted, before motion limiting. Lagging joints as the
    /// start would demand the whole lag at once and make the hand oscillate.
    pub fn accept(&mut self, q: HandVector) {
        self.q = q;
    }

    /// Returns a command that keeps the hand still.
    #[must_use]
    pub fn hold_still(&self) -> HandCommand {
        HandCommand {
            q: self.q,
            closing_m_s: PerSide::repeat(0.0),
        }
    }

    /// Returns the command of one step towards the intent.
    pub fn update(
        &mut self,
        hand: &HandModel,
        intent: &Intent,
        percept: &Percept,
        step_s: f64,
    ) -> HandCommand {
        let mut closing_m_s = self.integrate(intent, step_s);
        let (pose, n) = (hand.forward(&self.q), self.closing_axis(hand));
        if intent.pose.is_none_or(|carried| !carried.with_fingers) {
            self.limit_windup(hand, &pose, &n);
            let along_m = self.load_sharing.update(hand, percept, step_s);
            for (side, &along_m) in along_m.entries() {
                if along_m != 0.0 {
                    self.pose.half_opening_m[side] -= along_m;
                    closing_m_s[side] += along_m / step_s;
                }
            }
        }
        let jacobian = hand.jacobian(&pose);
        let mut corrected = self.pose;
        let bend_m = self.grip_bending_m(hand, (&pose, &jacobian, &n), percept, step_s);
        for (up_m, bend_m) in corrected.up_m.iter_mut().zip(bend_m) {
            *up_m -= bend_m.clamp(-COMPLIANCE_MAX_M, COMPLIANCE_MAX_M);
        }
        let weights = self.weights(step_s);
        let mut target = corrected.target(hand);
        self.load_sharing.apply_to(hand, &mut target);
        let step = hand.ik_step(&pose, &jacobian, &target, step_s, &weights);
        let q = if step.status == IkStatus::Failed {
            self.q
        } else {
            step.q
        };
        let by_joints_m = finger_closing_m(hand, &jacobian, &(q - self.q), &n);
        for (closing_m_s, by_joints_m) in closing_m_s.iter_mut().zip(by_joints_m) {
            *closing_m_s = closing_m_s.max(by_joints_m / step_s);
        }
        HandCommand { q, closing_m_s }
    }

    /// Returns the upward shift of the fingertip surfaces at the contact due to the grip, m:
    /// J·K⁻¹·Jᵀ·F of both sides, because their forces cancel in the arm. Most of it is fingertip
    /// rotation. The force difference between the sides is excluded: correcting it would amplify
    /// the object's swaying.
    fn grip_bending_m(
        &mut self,
        hand: &HandModel,
        (pose, jacobian, n): (&HandPose, &HandJacobian, &Vector3<f64>),
        percept: &Percept,
        step_s: f64,
    ) -> PerSide<f64> {
        let share = step_s / (COMPLIANCE_FILTER_S + step_s);
        self.grip_force_n += (percept.mean_normal_n() - self.grip_force_n) * share;
        // The object presses each side outwards.
        let mut force_n = [Vector3::zeros(); FINGERTIPS_MAX];
        for side in GraspSide::BOTH {
            let share_n = self.grip_force_n / hand.fingertips_of(side).count() as f64;
            for finger in hand.fingertips_of(side) {
                force_n[finger] = n * (side.outward() * share_n);
            }
        }
        let stiffness = hand.stiffness();
        let bent_rad = jacobian
            .torques_n_m(&force_n)
            .zip_map(&stiffness, |torque_n_m, k| torque_n_m / k);
        let bend_m = |finger: usize| {
            let moved_m = HandJacobian::moved(&jacobian.tips[finger].position, &bent_rad);
            let arm_m = pose.dome_axis(finger) * hand.tip_radius_m()[finger];
            let turned_rad = HandJacobian::moved(&jacobian.tips[finger].angular, &bent_rad);
            moved_m.z + turned_rad.cross(&arm_m).z
        };
        PerSide::from_fn(|side| hand.mean_of_side(side, bend_m))
    }

    /// Returns the weights. The gain towards the preferred posture builds up slowly; otherwise the
    /// first tick would jump.
    fn weights(&mut self, step_s: f64) -> IkWeights {
        self.secondary = (self.secondary + step_s / SECONDARY_BUILD_UP_S).min(1.0);
        let step_share = (step_s / SECONDARY_STEP_S).min(SECONDARY_STEPS_MAX);
        let gain = IkWeights::TICK.secondary_gain * step_share * self.secondary;
        IkWeights {
            secondary_gain: gain,
            ..IkWeights::TICK
        }
    }

    /// Anti-windup of the commanded opening. Otherwise a blocked closing request delays opening,
    /// and a request to close one side blocks both on a hand that cannot shift.
    fn limit_windup(&mut self, hand: &HandModel, pose: &HandPose, n: &Vector3<f64>) {
        let radius_m = hand.tip_radius_m();
        let is_m = PerSide::from_fn(|side| {
            let from_centre_m = pose.side_m(side) - self.pose.centre_m;
            let radius_m = hand.mean_of_side(side, |tip| radius_m[tip]);
            side.outward() * from_centre_m.dot(n) - radius_m
        });
        let half_opening_m = &mut self.pose.half_opening_m;
        let ahead_m = |side| half_opening_m[side] - is_m[side];
        let shift_m = (ahead_m(GraspSide::First) - ahead_m(GraspSide::Second)) / 2.0;
        let beyond_m = shift_m - shift_m.clamp(-SHIFT_LEAD_MAX_M, SHIFT_LEAD_MAX_M);
        if beyond_m != 0.0 {
            half_opening_m[GraspSide::First] -= beyond_m;
            half_opening_m[GraspSide::Second] += beyond_m;
        }
        for (half_opening_m, is_m) in half_opening_m.iter_mut().zip(is_m) {
            let least_m = is_m - OPENING_LEAD_MAX_M;
            if *half_opening_m < least_m {
                *half_opening_m = least_m;
            }
        }
    }

    /// Integrates the commanded pose; returns its closing speed per side, m/s.
    fn integrate(&mut self, intent: &Intent, step_s: f64) -> PerSide<f64> {
        let before_m = self.pose.half_opening_m;
        let carried_fingers = match intent.pose {
            Some(carried) => {
                self.pose = carried.pose;
                carried.with_fingers
            }
            None => false,
        };
        if !carried_fingers {
            self.pose.half_opening_m =
                before_m.zip_map(intent.closing_m_s, |before_m, m_s| before_m - m_s * step_s);
        }
        before_m.zip_map(self.pose.half_opening_m, |before_m, now_m| {
            (before_m - now_m) / step_s
        })
    }
}

/// Returns the closing travel of each side along the axis n due to finger joints only, m; a shared
/// drive can close the other side.
fn finger_closing_m(
    hand: &HandModel,
    jacobian: &HandJacobian,
    dq: &HandVector,
    n: &Vector3<f64>,
) -> PerSide<f64> {
    let mut fingers = *dq;
    fingers[hand.arm_joints()].fill(0.0);
    PerSide::from_fn(|side| {
        let inwards = n * -side.outward();
        hand.mean_of_side(side, |finger| {
            HandJacobian::moved(&jacobian.tips[finger].position, &fingers).dot(&inwards)
        })
    })
}

/// Returns the distance between the sides' fingertip centres, m; basis of the measured closing.
#[must_use]
pub fn gap_m(pose: &HandPose) -> f64 {
    pose.across_m().norm()
}

/// Returns the grasp pose of a hand: its target places the fingertips where they are.
#[must_use]
pub fn grasp_pose(hand: &HandModel, pose: &HandPose) -> GraspPose {
    let [tip1_m, tip2_m] = GraspSide::BOTH.map(|side| pose.side_m(side));
    let centre_m = (tip1_m + tip2_m) / 2.0;
    let across = Vector2::new(tip1_m.x - tip2_m.x, tip1_m.y - tip2_m.y);
    let axis = hand.hand_axis_of_tips(pose).unwrap_or(pose.hand_axis());
    let azimuth_rad = hand.bearing_rad(&centre_m);
    let (sin, cos) = libm::sincos(azimuth_rad);
    // The hand may lean backwards.
    let forward = libm::copysign(axis.xy().norm(), axis.x * cos + axis.y * sin);
    let radius_m = hand.tip_radius_m();
    let half_m = across.norm() / 2.0;
    let q = pose.q();
    GraspPose {
        centre_m,
        closing_yaw_rad: unwound_yaw_rad(hand, q, &centre_m, libm::atan2(across.y, across.x)),
        hand_azimuth_rad: azimuth_rad,
        hand_pitch_rad: libm::atan2(-axis.z, forward),
        root_rad: hand.root_rad(q),
        half_opening_m: PerSide::from_fn(|side| {
            half_m - hand.mean_of_side(side, |finger| radius_m[finger])
        }),
        tangential_m: PerSide::repeat(0.0),
        up_m: PerSide::new(tip1_m.z - centre_m.z, tip2_m.z - centre_m.z),
    }
}

/// Returns the yaw plus the full turns that match the wrist, rad.
fn unwound_yaw_rad(hand: &HandModel, q: &HandVector, centre_m: &Vector3<f64>, yaw_rad: f64) -> f64 {
    use core::f64::consts::TAU;
    let by_wrist = hand.yaw_of_joints_rad(q, centre_m);
    yaw_rad + TAU * libm::round((by_wrist - yaw_rad) / TAU)
}
