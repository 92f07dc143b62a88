//! Postures from scratch: repeated steps of the inverse kinematics, and the start that makes them converge.

use core::fmt;

use crate::forward::HandPose;
use crate::ik::{IkStatus, IkWeights};
use crate::model::HandModel;
use crate::target::{GraspFrame, HandTarget};
use crate::vector::HandVector;

/// Time that one iteration of [`HandModel::solve`] may use of each joint's speed, seconds: 0.4–1 rad per iteration. Ours:
/// so wide that joints are rarely held back; at 0.05 s and a secondary gain of 1, 0.4 % of the workspace did not converge.
const SOLVE_STEP_S: f64 = 0.2;

/// Iterations of [`HandModel::posture_for`]. Ours: 50 already give every posture of the workspace the same error.
pub const POSTURE_ITERATIONS: usize = 60;

/// Tip error below which a posture counts as reached, metres. Ours: half the 2 µm position quantum.
pub const POSTURE_TIP_ERROR_MAX_M: f64 = 1e-6;

/// How far one of several tips of a side may be from its target while their middle is there, metres (ours: a fingertip is soft
/// over a tenth of that, and each closes until it touches by itself).
pub const POSTURE_SPREAD_ERROR_MAX_M: f64 = 2e-3;

/// Dome-axis error below which a posture counts as reached, radians (1°). Ours.
pub const POSTURE_DOME_ERROR_MAX_RAD: f64 = 0.0175;

/// A posture with what is left of the error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Joint angles, radians, inside the limits.
    pub q_rad: HandVector,
    /// Distance of the farther side's middle from its target, metres; infinite if the target was not finite.
    pub tip_error_m: f64,
    /// Distance of the farthest tip from its target, metres; infinite if the target was not finite.
    pub spread_error_m: f64,
    /// Angle of the worse dome axis from its target, radians; infinite if the target was not finite.
    pub dome_error_rad: f64,
}

/// A grasp that no posture of the hand meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unreachable {
    /// The best posture found.
    pub best: Solution,
}

impl fmt::Display for Unreachable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "could not reach the grasp because the best posture left {:.3} mm of tip error and {:.2}° of dome axis, \
             needs at most {:.3} mm and {:.2}°; move the object into the workspace or choose another closing yaw",
            self.best.tip_error_m * 1e3,
            self.best.dome_error_rad.to_degrees(),
            POSTURE_TIP_ERROR_MAX_M * 1e3,
            POSTURE_DOME_ERROR_MAX_RAD.to_degrees(),
        )
    }
}

impl core::error::Error for Unreachable {}

impl HandModel {
    /// Up to `iterations` steps from `start_rad` towards `target`, without regard for time: for start postures, not for
    /// the control tick. Stops early when a step fails.
    #[must_use]
    pub fn solve(
        &self,
        start_rad: &HandVector,
        target: &HandTarget,
        iterations: usize,
    ) -> Solution {
        let mut pose = self.forward(start_rad);
        for _ in 0..iterations {
            let step = self.ik_step(
                &pose,
                &self.jacobian(&pose),
                target,
                SOLVE_STEP_S,
                &IkWeights::SOLVE,
            );
            if step.status == IkStatus::Failed {
                break;
            }
            pose = self.forward(&step.q_rad);
        }
        Solution::new(self, &pose, target)
    }

    /// The posture for a grasp, reached from the reference posture with the arm turned towards the grasp and the wrist
    /// rolled to its closing yaw. Takes the closing yaw as it is: pass it through
    /// [`closing_yaw_rad`](Self::closing_yaw_rad) first.
    ///
    /// # Errors
    /// [`Unreachable`] if tips or dome axes stay farther off than [`POSTURE_TIP_ERROR_MAX_M`] and
    /// [`POSTURE_DOME_ERROR_MAX_RAD`].
    pub fn posture_for(&self, grasp: &GraspFrame) -> Result<Solution, Unreachable> {
        let mut start = self.reference_rad;
        let yaw_rad = grasp.as_done_by(self).closing_yaw_rad;
        self.turn_towards(&mut start, &grasp.centre_m, yaw_rad);
        let best = self.solve(
            &self.clamp_to_limits(&start),
            &grasp.target(self),
            POSTURE_ITERATIONS,
        );
        let reached = best.tip_error_m <= POSTURE_TIP_ERROR_MAX_M
            && best.spread_error_m <= POSTURE_SPREAD_ERROR_MAX_M
            && best.dome_error_rad <= POSTURE_DOME_ERROR_MAX_RAD;
        if reached {
            Ok(best)
        } else {
            Err(Unreachable { best })
        }
    }

    /// The nearest posture inside the limits; angles that are not finite become the reference posture's.
    #[must_use]
    pub fn clamp_to_limits(&self, q_rad: &HandVector) -> HandVector {
        HandVector::from_fn(self.joint_count, |index| {
            let (joint, q) = (&self.joints[index], q_rad[index]);
            if q.is_finite() {
                q.clamp(joint.lower_rad, joint.upper_rad)
            } else {
                self.reference_rad[index]
            }
        })
    }
}

impl Solution {
    fn new(hand: &HandModel, pose: &HandPose, target: &HandTarget) -> Solution {
        let worst = |error: fn(&HandPose, &HandTarget, usize) -> f64| {
            let fingers = 0..pose.base_from_tip().len();
            fingers.fold(0.0_f64, |worst, finger| {
                let error = error(pose, target, finger);
                let known = error.is_finite() && worst.is_finite();
                if known {
                    worst.max(error)
                } else {
                    f64::INFINITY
                }
            })
        };
        let spread_error_m =
            worst(|pose, target, finger| (target.tip_m[finger] - pose.tip_m(finger)).norm());
        let tip_error_m = if spread_error_m.is_finite() {
            hand.side_error_m(|finger| target.tip_m[finger] - pose.tip_m(finger))
        } else {
            f64::INFINITY
        };
        Solution {
            q_rad: *pose.q_rad(),
            tip_error_m,
            spread_error_m,
            dome_error_rad: worst(|pose, target, finger| {
                let (is, wanted) = (pose.dome_axis(finger), target.dome_axis[finger]);
                libm::atan2(is.cross(&wanted).norm(), is.dot(&wanted))
            }),
        }
    }
}
