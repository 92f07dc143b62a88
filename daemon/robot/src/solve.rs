//! Postures from an arbitrary start: repeated inverse-kinematics steps, and the start posture that
//! makes them converge.

use core::fmt;

use crate::forward::HandPose;
use crate::ik::{IkStatus, IkWeights};
use crate::model::HandModel;
use crate::target::{GraspPose, HandTarget};
use crate::vector::HandVector;

/// Time per iteration of [`HandModel::solve`] for each joint's speed limit, seconds: 0.4–1 rad per
/// iteration. Design choice: joints are rarely held back. At 0.05 s and a secondary gain of 1, 0.4
/// % of the workspace did not converge.
const SOLVE_STEP_S: f64 = 0.2;

/// Iterations of [`HandModel::posture_for`]. Design choice: 50 already give every posture of the
/// workspace the same error.
pub const POSTURE_ITERATIONS: usize = 60;

/// Tip error below which a posture is reached, metres. Design choice: half the 2 µm position
/// quantum.
pub const POSTURE_TIP_ERROR_MAX_M: f64 = 1e-6;

/// Largest distance of one of several tips of a side from its target while their middle is at its
/// target, metres. Design choice: each fingertip closes separately until it touches, so small
/// differences are harmless.
pub const POSTURE_SPREAD_ERROR_MAX_M: f64 = 2e-3;

/// Dome-axis error below which a posture is reached, radians: 1°. Design choice.
pub const POSTURE_DOME_ERROR_MAX_RAD: f64 = 0.0175;

/// Dome-axis limit of an open hand whose domes cannot all face each other, radians: 45°. Design
/// choice: an open hand touches nothing. [`HandModel::dome_error_max_rad`] is the limit in contact.
const TILTED_DOME_ERROR_MAX_RAD: f64 = core::f64::consts::FRAC_PI_4;

/// Posture with its remaining errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Joint positions, within the limits.
    pub q: HandVector,
    /// Distance of the farther side's middle from its target, metres; infinite if the target was
    /// not finite.
    pub tip_error_m: f64,
    /// Distance of the farthest tip from its target, metres; infinite if the target was not finite.
    pub spread_error_m: f64,
    /// Angle of the worse dome axis from its target, radians; infinite if the target was not
    /// finite.
    pub dome_error_rad: f64,
}

/// Error of a grasp that no posture of the hand reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unreachable {
    /// Best posture found.
    pub best: Solution,
    /// Largest permitted dome-axis error, radians.
    pub dome_error_max_rad: f64,
}

impl fmt::Display for Unreachable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Solution {
            tip_error_m,
            spread_error_m,
            dome_error_rad,
            ..
        } = self.best;
        f.write_str("could not reach the grasp because in the best posture ")?;
        if tip_error_m > POSTURE_TIP_ERROR_MAX_M {
            write!(
                f,
                "the fingertips of one side stayed {:.3} mm off, needs at most {:.3} mm; move the object into the workspace or \
                 choose another closing yaw",
                tip_error_m * 1e3,
                POSTURE_TIP_ERROR_MAX_M * 1e3,
            )
        } else if spread_error_m > POSTURE_SPREAD_ERROR_MAX_M {
            write!(
                f,
                "one of several fingertips of a side stayed {:.1} mm beside its place while their middle was met, needs at most \
                 {:.1} mm; let fingertips of one side stand in a line across the hand's `down` and the closing axis",
                spread_error_m * 1e3,
                POSTURE_SPREAD_ERROR_MAX_M * 1e3,
            )
        } else {
            write!(
                f,
                "a fingertip faced {:.2}° beside the closing axis, needs at most {:.2}°; choose another closing yaw or opening, or \
                 correct `facing`",
                dome_error_rad.to_degrees(),
                self.dome_error_max_rad.to_degrees(),
            )
        }
    }
}

impl core::error::Error for Unreachable {}

impl HandModel {
    /// Runs up to `iterations` steps from `start` towards `target`. For start postures, not for
    /// the control tick. Stops early when a step fails.
    #[must_use]
    pub fn solve(&self, start: &HandVector, target: &HandTarget, iterations: usize) -> Solution {
        let mut pose = self.forward(start);
        for _ in 0..iterations {
            let Some(next) = self.solve_step(&pose, target) else {
                break;
            };
            pose = next;
        }
        Solution::new(self, &pose, target)
    }

    /// Returns the posture for a grasp. The search starts from the reference posture with the arm
    /// turned towards the grasp and the wrist rolled to its closing yaw. It keeps the closing yaw;
    /// pass it through [`closing_yaw_rad`](Self::closing_yaw_rad) first.
    ///
    /// # Errors
    /// [`Unreachable`] if the error of tips or dome axes exceeds [`POSTURE_TIP_ERROR_MAX_M`] or
    /// [`POSTURE_DOME_ERROR_MAX_RAD`]. If the hand's domes cannot all face each other
    /// ([`HandModel::domes_tilt`]), a wider limit applies.
    pub fn posture_for(&self, grasp: &GraspPose) -> Result<Solution, Unreachable> {
        self.posture_within(grasp, self.open_dome_error_max_rad())
    }

    /// Returns true if [`posture_for`](Self::posture_for) reaches the grasp. It ends at the first
    /// success and is about five times as fast.
    #[must_use]
    pub fn reaches(&self, grasp: &GraspPose) -> bool {
        let target = grasp.target(self);
        let mut pose = self.forward(&self.start_for(grasp));
        for _ in 0..POSTURE_ITERATIONS {
            let so_far = Solution::new(self, &pose, &target);
            if so_far.is_within(self.open_dome_error_max_rad()) {
                return true;
            }
            let Some(next) = self.solve_step(&pose, &target) else {
                break;
            };
            pose = next;
        }
        Solution::new(self, &pose, &target).is_within(self.open_dome_error_max_rad())
    }

    /// Returns the dome-axis limit of an open hand, radians.
    fn open_dome_error_max_rad(&self) -> f64 {
        if self.domes_tilt {
            TILTED_DOME_ERROR_MAX_RAD
        } else {
            POSTURE_DOME_ERROR_MAX_RAD
        }
    }

    /// Returns the posture for a grasp in contact, with the stricter dome-axis limit of a touching
    /// hand.
    ///
    /// # Errors
    /// [`Unreachable`], as [`posture_for`](Self::posture_for), with
    /// [`dome_error_max_rad`](Self::dome_error_max_rad).
    pub fn contact_posture_for(&self, grasp: &GraspPose) -> Result<Solution, Unreachable> {
        self.posture_within(grasp, self.dome_error_max_rad())
    }

    /// Returns the posture for a grasp with this dome-axis limit, radians.
    pub(crate) fn posture_within(
        &self,
        grasp: &GraspPose,
        dome_error_max_rad: f64,
    ) -> Result<Solution, Unreachable> {
        let start = self.start_for(grasp);
        let best = self.solve(&start, &grasp.target(self), POSTURE_ITERATIONS);
        if best.is_within(dome_error_max_rad) {
            Ok(best)
        } else {
            Err(Unreachable {
                best,
                dome_error_max_rad,
            })
        }
    }

    /// Returns the reference posture with the arm turned towards a grasp and the wrist rolled to
    /// its closing yaw.
    fn start_for(&self, grasp: &GraspPose) -> HandVector {
        let mut start = self.reference;
        let yaw_rad = grasp.executed_by(self).closing_yaw_rad;
        self.turn_towards(&mut start, &grasp.centre_m, yaw_rad);
        self.clamp_to_limits(&start)
    }

    /// Returns the pose after one step, or `None` if the step fails.
    fn solve_step(&self, pose: &HandPose, target: &HandTarget) -> Option<HandPose> {
        let (jacobian, weights) = (self.jacobian(pose), &IkWeights::SOLVE);
        let step = self.ik_step(pose, &jacobian, target, SOLVE_STEP_S, weights);
        (step.status != IkStatus::Failed).then(|| self.forward(&step.q))
    }

    /// Returns the nearest posture within the limits. Values that are not finite become those of
    /// the reference posture.
    #[must_use]
    pub fn clamp_to_limits(&self, q: &HandVector) -> HandVector {
        HandVector::from_fn(self.joint_count, |index| {
            let (joint, q) = (&self.joints[index], q[index]);
            if q.is_finite() {
                q.clamp(joint.lower, joint.upper)
            } else {
                self.reference[index]
            }
        })
    }
}

impl Solution {
    /// Returns true if tips and domes are within their limits.
    fn is_within(&self, dome_error_max_rad: f64) -> bool {
        self.meets_tips() && self.dome_error_rad <= dome_error_max_rad
    }

    /// Returns true if all tips are within their limits: the middle of each side, and each tip
    /// relative to it.
    #[must_use]
    pub fn meets_tips(&self) -> bool {
        self.tip_error_m <= POSTURE_TIP_ERROR_MAX_M
            && self.spread_error_m <= POSTURE_SPREAD_ERROR_MAX_M
    }

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
            q: *pose.q(),
            tip_error_m,
            spread_error_m,
            dome_error_rad: worst(|pose, target, finger| {
                let (is, wanted) = (pose.dome_axis(finger), target.dome_axis[finger]);
                libm::atan2(is.cross(&wanted).norm(), is.dot(&wanted))
            }),
        }
    }
}
