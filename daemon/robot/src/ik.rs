//! Inverse kinematics of one hand: one constrained least-squares step per control tick.
//!
//! Integrate on the commanded angles, starting from the last command. With tip Jacobian J_p, dome-axis Jacobian J_a,
//! hand-axis Jacobian J_h and their errors e, each step minimises
//!
//! ```text
//!   w_a²·|J_a·dq − g·e_a|² + w_h²·|J_h·dq − g·e_h|² + Σ w_j²·(dq_j − g·(q_ref,j − q_j))² + λ²·|dq|²
//!   subject to  J_p·dq = e_p (softened by ε)   and   limits − q ≤ dq ≤ limits − q,  |dq| ≤ v_max·dt
//! ```
//!
//! Tip positions are met first, dome axes next, then the hand's direction, then the reference posture. The box is met by
//! an active set of at most [`ACTIVE_SET_PASSES`] solves and a final clamp. A step that cannot be computed moves nothing
//! and says so. Deliberately absent: any memory (the caller owns the command), any clock.

use crate::arrow::{ArrowSystem, FingerBlock};
use crate::forward::HandPose;
use crate::jacobian::HandJacobian;
use crate::model::{HandModel, finger_root};
use crate::sizes::{ARM_JOINTS, FINGER_JOINTS, FINGERS, HAND_JOINTS, HandVector};
use crate::target::HandTarget;
use nalgebra::{SMatrix, SVector, Vector3};

/// Solves per step: joints found outside the box are held at its edge and the rest solved again. Ours: three bound the
/// time of a step; joints that are still outside after the last one are clamped.
pub const ACTIVE_SET_PASSES: usize = 3;

/// How far outside its box a joint may be before it counts as outside, radians: rounding of the solve. Ours.
const BOX_TOLERANCE_RAD: f64 = 1e-12;

/// Weights of the least-squares step. The values of [`IkWeights::TICK`] are ours, tuned on a prototype.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IkWeights {
    /// w_a, weight of the dome axes.
    pub dome_axis: f64,
    /// w_h, weight of the hand's direction.
    pub hand_axis: f64,
    /// w, weight of the reference posture of every joint but the finger roots. At rest anywhere in the workspace 0.02
    /// costs the dome axes at most 0.09°, 0.04 costs 0.28° (measured).
    pub posture: f64,
    /// w of the finger roots.
    pub root_posture: f64,
    /// λ, damping of dq.
    pub damping: f64,
    /// g, the fraction of each secondary error removed per step; the same for all of them, because unequal gains jump
    /// at the start of a move (45 rad/s² in a prototype). The price is lag: 0.6° of dome axis while an empty hand
    /// turns by 30° in 2 s (measured).
    pub secondary_gain: f64,
    /// ε at small tip errors, m²: keeps the solve regular when the tips cannot move as asked.
    pub softening_m2: f64,
    /// Growth of ε with the tip error beyond [`softening_from_m`](Self::softening_from_m), m² per metre: stops chatter
    /// at the speed limit when a target is out of reach.
    pub softening_slope_m: f64,
    /// Tip error from which ε grows, metres.
    pub softening_from_m: f64,
    /// Longest tip motion asked of one step, metres; a farther target is approached at this length per step.
    pub tip_step_max_m: f64,
}

impl IkWeights {
    /// One step per 1 ms control tick.
    pub const TICK: IkWeights = IkWeights {
        dome_axis: 1.0,
        hand_axis: 0.15,
        posture: 0.02,
        root_posture: 0.05,
        damping: 1e-3,
        secondary_gain: 0.05,
        softening_m2: 1e-7,
        softening_slope_m: 1e2,
        softening_from_m: 1e-3,
        tip_step_max_m: 2e-3,
    };

    /// Steps of [`HandModel::solve`]: long, without regard for smoothness.
    pub const SOLVE: IkWeights = IkWeights {
        secondary_gain: 0.3,
        softening_slope_m: 0.0,
        tip_step_max_m: 0.03,
        ..IkWeights::TICK
    };
}

/// How a step ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IkStatus {
    /// No joint was held back.
    Free,
    /// At least one joint was held back by its position limit or its speed limit.
    AtLimit,
    /// The step could not be computed (an input was not finite, or the equations were singular): nothing moves.
    Failed,
}

/// One step of the inverse kinematics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IkStep {
    /// The next command, radians: the pose's angles plus `dq_rad`, inside the position limits if the pose was.
    pub q_rad: HandVector,
    /// The change, radians; always finite, at most v_max·dt per joint.
    pub dq_rad: HandVector,
    /// How the step ended.
    pub status: IkStatus,
    /// Distance of the farther tip from its target before the step, metres; infinite if the step failed.
    pub tip_error_m: f64,
}

/// What is wrong at the pose, and how hard to correct it.
struct TaskError {
    tip: [Vector3<f64>; FINGERS],
    dome_axis: [Vector3<f64>; FINGERS],
    hand_axis: Vector3<f64>,
    tip_error_m: f64,
}

/// Range of each joint's change in one step.
struct StepBox {
    lower: HandVector,
    upper: HandVector,
}

impl HandModel {
    /// One step from `pose` towards `target` in `dt_s` seconds. `jacobian` must be the one of `pose`.
    #[must_use]
    pub fn ik_step(
        &self,
        pose: &HandPose,
        jacobian: &HandJacobian,
        target: &HandTarget,
        dt_s: f64,
        weights: &IkWeights,
    ) -> IkStep {
        self.try_ik_step(pose, jacobian, target, dt_s, weights)
            .unwrap_or(IkStep {
                q_rad: *pose.q_rad(),
                dq_rad: HandVector::zeros(),
                status: IkStatus::Failed,
                tip_error_m: f64::INFINITY,
            })
    }

    fn try_ik_step(
        &self,
        pose: &HandPose,
        jacobian: &HandJacobian,
        target: &HandTarget,
        dt_s: f64,
        weights: &IkWeights,
    ) -> Option<IkStep> {
        let error = TaskError::new(pose, target, weights)?;
        let step_box = self.step_box(pose.q_rad(), dt_s)?;
        let system = self.system(pose.q_rad(), jacobian, target.root_rad, &error, weights);
        let (dq_rad, status) = solve_in_box(system, &step_box)?;
        let q_rad = self.advance(pose.q_rad(), &dq_rad);
        Some(IkStep {
            q_rad,
            dq_rad: q_rad - pose.q_rad(),
            status,
            tip_error_m: error.tip_error_m,
        })
    }

    /// `None` unless every angle and the time step are usable numbers.
    fn step_box(&self, q_rad: &HandVector, dt_s: f64) -> Option<StepBox> {
        let usable = dt_s.is_finite() && dt_s > 0.0 && q_rad.iter().all(|q| q.is_finite());
        if !usable {
            return None;
        }
        let mut step_box = StepBox {
            lower: HandVector::zeros(),
            upper: HandVector::zeros(),
        };
        for (index, joint) in self.joints.iter().enumerate() {
            // Clamping both ends to the speed limit lets a joint that starts outside come back no faster than it may.
            let reach = joint.velocity_max_rad_s * dt_s;
            step_box.lower[index] = (joint.lower_rad - q_rad[index]).clamp(-reach, reach);
            step_box.upper[index] = (joint.upper_rad - q_rad[index]).clamp(-reach, reach);
        }
        Some(step_box)
    }

    fn system(
        &self,
        q_rad: &HandVector,
        jacobian: &HandJacobian,
        root_rad: f64,
        error: &TaskError,
        weights: &IkWeights,
    ) -> ArrowSystem {
        let posture = self.posture_rows(q_rad, root_rad, weights);
        let w_hand = weights.hand_axis * weights.hand_axis;
        let hand = jacobian.hand_axis.fixed_columns::<ARM_JOINTS>(0);
        let mut arm_h = hand.tr_mul(&hand) * w_hand + diagonal::<ARM_JOINTS>(&posture.h, 0);
        let mut arm_g =
            hand.tr_mul(&error.hand_axis) * w_hand + segment::<ARM_JOINTS>(&posture.g, 0);
        let w_dome = weights.dome_axis * weights.dome_axis;
        let mut finger_block = |finger: usize| {
            let (row, root) = (3 * finger, finger_root(finger));
            let arm = jacobian.dome_axis.fixed_view::<3, ARM_JOINTS>(row, 0);
            let own = jacobian.dome_axis.fixed_view::<3, FINGER_JOINTS>(row, root);
            arm_h += arm.tr_mul(&arm) * w_dome;
            arm_g += arm.tr_mul(&error.dome_axis[finger]) * w_dome;
            FingerBlock {
                h: own.tr_mul(&own) * w_dome + diagonal::<FINGER_JOINTS>(&posture.h, root),
                cross: own.tr_mul(&arm) * w_dome,
                g: own.tr_mul(&error.dome_axis[finger]) * w_dome
                    + segment::<FINGER_JOINTS>(&posture.g, root),
                tip_by_finger: jacobian
                    .tip
                    .fixed_view::<3, FINGER_JOINTS>(row, root)
                    .transpose(),
                tip_by_arm: jacobian.tip.fixed_view::<3, ARM_JOINTS>(row, 0).transpose(),
                e: error.tip[finger],
            }
        };
        let fingers = [finger_block(0), finger_block(1)];
        let excess_m = (error.tip_error_m - weights.softening_from_m).max(0.0);
        let softening = weights.softening_m2 + weights.softening_slope_m * excess_m;
        ArrowSystem {
            fingers,
            arm_h,
            arm_g,
            softening,
        }
    }

    /// The diagonal of H and the part of g that pull towards the reference posture.
    fn posture_rows(&self, q_rad: &HandVector, root_rad: f64, weights: &IkWeights) -> PostureRows {
        let mut weight = HandVector::repeat(weights.posture * weights.posture);
        let mut wanted = self.reference_rad;
        for finger in 0..FINGERS {
            weight[finger_root(finger)] = weights.root_posture * weights.root_posture;
            wanted[finger_root(finger)] = root_rad;
        }
        PostureRows {
            h: weight.add_scalar(weights.damping * weights.damping),
            g: weight.component_mul(&(wanted - q_rad)) * weights.secondary_gain,
        }
    }

    /// q + dq without the last bit of rounding beyond a limit.
    fn advance(&self, q_rad: &HandVector, dq_rad: &HandVector) -> HandVector {
        HandVector::from_fn(|index, _| {
            let (joint, q) = (&self.joints[index], q_rad[index]);
            (q + dq_rad[index]).clamp(joint.lower_rad.min(q), joint.upper_rad.max(q))
        })
    }
}

struct PostureRows {
    h: HandVector,
    g: HandVector,
}

fn segment<const N: usize>(vector: &HandVector, start: usize) -> SVector<f64, N> {
    vector.fixed_rows::<N>(start).into_owned()
}

fn diagonal<const N: usize>(vector: &HandVector, start: usize) -> SMatrix<f64, N, N> {
    SMatrix::from_diagonal(&segment::<N>(vector, start))
}

impl TaskError {
    /// `None` if the target or the pose is not finite, or so far apart that their distance is not.
    fn new(pose: &HandPose, target: &HandTarget, weights: &IkWeights) -> Option<TaskError> {
        if !target.is_finite() {
            return None;
        }
        let tip = [
            target.tip_m[0] - pose.tip_m(0),
            target.tip_m[1] - pose.tip_m(1),
        ];
        let tip_errors_m = [tip[0].norm(), tip[1].norm()];
        if !tip_errors_m.iter().all(|error| error.is_finite()) {
            return None;
        }
        let tip_error_m = tip_errors_m[0].max(tip_errors_m[1]);
        let shorten = if tip_error_m > weights.tip_step_max_m {
            weights.tip_step_max_m / tip_error_m
        } else {
            1.0
        };
        let gain = weights.secondary_gain;
        Some(TaskError {
            tip: tip.map(|error| error * shorten),
            dome_axis: [0, 1]
                .map(|finger| (target.dome_axis[finger] - pose.dome_axis(finger)) * gain),
            hand_axis: (target.hand_axis - pose.hand_axis()) * gain,
            tip_error_m,
        })
    }
}

/// Solves, holds the joints that left the box at its edge, solves the rest again; clamps what is left.
fn solve_in_box(mut system: ArrowSystem, step_box: &StepBox) -> Option<(HandVector, IkStatus)> {
    let mut held = [false; HAND_JOINTS];
    let mut status = IkStatus::Free;
    let mut dq = system.solve()?;
    for pass in 1..=ACTIVE_SET_PASSES {
        if !dq.iter().all(|value| value.is_finite()) {
            return None;
        }
        let mut changed = false;
        for joint in 0..HAND_JOINTS {
            let (lower, upper) = (step_box.lower[joint], step_box.upper[joint]);
            let outside =
                dq[joint] < lower - BOX_TOLERANCE_RAD || dq[joint] > upper + BOX_TOLERANCE_RAD;
            if outside && !held[joint] {
                held[joint] = true;
                changed = true;
                system.hold(joint, dq[joint].clamp(lower, upper));
            }
        }
        if !changed {
            break;
        }
        status = IkStatus::AtLimit;
        if pass < ACTIVE_SET_PASSES {
            dq = system.solve()?;
        }
    }
    let clamped = HandVector::from_fn(|joint, _| {
        dq[joint].clamp(step_box.lower[joint], step_box.upper[joint])
    });
    Some((clamped, status))
}
