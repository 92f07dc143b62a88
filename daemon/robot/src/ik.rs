//! Inverse kinematics of one hand: one constrained least-squares step per control tick.
//!
//! Inputs: pose, Jacobian, target. Output: the next command. The caller integrates on commanded
//! positions, from the last command. With tip Jacobian J_p, dome-axis Jacobian J_a, hand-axis
//! Jacobian J_h and their errors e, each step minimises
//!
//! ```text
//!   w_a²·|J_a·dq − g·e_a|² + w_h²·|J_h·dq − g·e_h|² + λ²·|dq|²
//!     + Σ w_j²·(dq_j − g·(q_ref,j − q_j))²
//!   subject to  J_p·dq = e_p (softened by ε),  lower − q ≤ dq ≤ upper − q,  |dq| ≤ v_max·dt
//! ```
//!
//! Priorities: tip positions, dome axes, hand direction, reference posture. If several tips press
//! from one grasp side, only their middle is an equality constraint: a side acts as one *virtual
//! finger* (Arbib, Iberall and Lyons 1985). Differences between its tips are one more weighted
//! term, w_s²·|J_p·dq − e_p|² about the middle. Equality for every tip would leave such a hand no
//! freedom: two fingers that bend in parallel planes keep their distance.
//!
//! An active set of at most [`ACTIVE_SET_PASSES`] solves and a final clamp keep the limits. A step
//! that cannot be computed moves nothing and reports this. The module has no memory and no clock.

use crate::arrow::{ArrowSystem, FingerBlock};
use crate::forward::HandPose;
use crate::jacobian::{HandJacobian, Rows3};
use crate::model::HandModel;
use crate::sizes::{FINGERTIPS_MAX, HAND_JOINTS_MAX};
use crate::target::HandTarget;
use crate::vector::HandVector;
use arrayvec::ArrayVec;
use nalgebra::Vector3;

/// Largest number of solves per step. Joints outside the box are held at its edge and the others
/// are solved again. Design choice: three bound the time of a step; joints that are still outside
/// are clamped.
pub const ACTIVE_SET_PASSES: usize = 3;

/// Distance outside the box at which a joint counts as outside, radians: rounding of the solve.
const BOX_TOLERANCE_RAD: f64 = 1e-12;

/// Weights of the least-squares step. [`IkWeights::TICK`] was tuned on a prototype.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IkWeights {
    /// w_a, weight of the dome axes.
    pub dome_axis: f64,
    /// w_h, weight of the hand's direction.
    pub hand_axis: f64,
    /// w, weight of the reference posture of every joint but the finger roots. At rest anywhere in
    /// the workspace 0.02 costs the dome axes at most 0.09°, 0.04 costs 0.28° (measured).
    pub posture: f64,
    /// w of the finger roots, the joints that tilt a finger about the closing axis.
    pub root_posture: f64,
    /// w of a finger's only joint, which sets how both sides share the opening. Design choice: with
    /// a smaller weight, the posture of the arm moves the hand sideways until one of two jaws
    /// reaches its limit.
    pub lone_posture: f64,
    /// λ, damping of dq.
    pub damping: f64,
    /// g, the fraction of each secondary error removed per step; the same for all of them, because
    /// unequal gains jump at the start of a move (45 rad/s² in a prototype). The price is lag: 0.6°
    /// of dome axis while an empty hand turns by 30° in 2 s (measured).
    pub secondary_gain: f64,
    /// 1/w_s², tolerance of the differences between the tips of one side, m². Design choice: with
    /// 45 mm between two tips, a turn of the hand then costs as much by their places as by their
    /// dome axes. At 1e-2 the hand sways (measured).
    pub within_side_m2: f64,
    /// ε at small tip errors, m²: keeps the solve regular when the tips cannot move as requested.
    pub softening_m2: f64,
    /// Growth of ε with the tip error beyond [`softening_from_m`](Self::softening_from_m), m² per
    /// metre: stops chatter at the speed limit when a target is out of reach.
    pub softening_slope_m: f64,
    /// Tip error from which ε grows, metres.
    pub softening_from_m: f64,
    /// Longest tip motion of one step, metres. A farther target is approached in steps of this
    /// length.
    pub tip_step_max_m: f64,
}

impl IkWeights {
    /// One step per 1 ms control tick.
    pub const TICK: IkWeights = IkWeights {
        dome_axis: 1.0,
        hand_axis: 0.15,
        posture: 0.02,
        root_posture: 0.05,
        lone_posture: 1.0,
        damping: 1e-3,
        secondary_gain: 0.05,
        within_side_m2: 3e-4,
        softening_m2: 1e-7,
        softening_slope_m: 1e2,
        softening_from_m: 1e-3,
        tip_step_max_m: 2e-3,
    };

    /// Steps of [`HandModel::solve`]: long, not smooth.
    pub const SOLVE: IkWeights = IkWeights {
        secondary_gain: 0.3,
        softening_slope_m: 0.0,
        tip_step_max_m: 0.03,
        ..IkWeights::TICK
    };
}

/// Result of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IkStatus {
    /// No joint reached a limit.
    Free,
    /// A position or speed limit held at least one joint back.
    AtLimit,
    /// The step could not be computed: an input was not finite, or the equations were singular.
    /// Nothing moves.
    Failed,
}

/// One step of the inverse kinematics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IkStep {
    /// The next command, radians: the pose's angles plus `dq`, inside the position limits if
    /// the pose was.
    pub q: HandVector,
    /// The change, radians; always finite, at most v_max·dt per joint.
    pub dq: HandVector,
    /// Result of the step.
    pub status: IkStatus,
    /// Distance of the farther grasp side from its target before the step, metres, by the middle of
    /// its tips; infinite if the step failed.
    pub tip_error_m: f64,
}

/// Errors at the pose, and their weights.
struct TaskError {
    tip: [Vector3<f64>; FINGERTIPS_MAX],
    dome_axis: [Vector3<f64>; FINGERTIPS_MAX],
    hand_axis: Vector3<f64>,
    tip_error_m: f64,
}

/// Range of each joint's change in one step.
struct StepBox {
    lower: HandVector,
    upper: HandVector,
}

impl HandModel {
    /// Computes one step from `pose` towards `target` in `dt_s` seconds. `jacobian` must belong to
    /// `pose`.
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
                q: *pose.q(),
                dq: HandVector::zeros(pose.q().len()),
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
        let error = TaskError::new(self, pose, target, weights)?;
        let step_box = self.step_box(pose.q(), dt_s)?;
        let mut system = self.system(pose.q(), jacobian, target.root_rad, &error, weights);
        let (dq, status) = solve_in_box(&mut system, &step_box)?;
        let q = self.advance(pose.q(), &dq);
        Some(IkStep {
            q,
            dq: q - *pose.q(),
            status,
            tip_error_m: error.tip_error_m,
        })
    }

    /// Returns `None` if a joint position or the time step is invalid.
    fn step_box(&self, q: &HandVector, dt_s: f64) -> Option<StepBox> {
        let complete = q.len() == self.joint_count && q.iter().all(|q| q.is_finite());
        if !(complete && dt_s.is_finite() && dt_s > 0.0) {
            return None;
        }
        let mut step_box = StepBox {
            lower: HandVector::zeros(self.joint_count),
            upper: HandVector::zeros(self.joint_count),
        };
        for (index, joint) in self.joints().iter().enumerate() {
            // Clamping both ends to the speed limit lets a joint that starts outside come back no
            // faster than it may.
            let reach = joint.velocity_max * dt_s;
            step_box.lower[index] = (joint.lower - q[index]).clamp(-reach, reach);
            step_box.upper[index] = (joint.upper - q[index]).clamp(-reach, reach);
        }
        Some(step_box)
    }

    fn system(
        &self,
        q: &HandVector,
        jacobian: &HandJacobian,
        root_rad: f64,
        error: &TaskError,
        weights: &IkWeights,
    ) -> ArrowSystem {
        let (trunk, posture) = (self.trunk_joints, self.posture_rows(q, root_rad, weights));
        let excess_m = (error.tip_error_m - weights.softening_from_m).max(0.0);
        let w_dome = weights.dome_axis * weights.dome_axis;
        let mut system = ArrowSystem {
            fingers: ArrayVec::new(),
            trunk_h: Default::default(),
            trunk_g: Default::default(),
            trunk_joints: trunk,
            softening: weights.softening_m2 + weights.softening_slope_m * excess_m,
            softening_within: weights.within_side_m2,
        };
        let w_hand = weights.hand_axis * weights.hand_axis;
        let hand = &jacobian.hand_axis;
        for j in 0..trunk {
            for i in 0..trunk {
                system.trunk_h[(i, j)] = columns(hand, i, j) * w_hand;
            }
            system.trunk_h[(j, j)] += posture.h[j];
            system.trunk_g[j] = along(hand, j, &error.hand_axis) * w_hand + posture.g[j];
        }
        for finger in 0..self.finger_count {
            let (dome, e) = (&jacobian.tips[finger].dome_axis, &error.dome_axis[finger]);
            for j in 0..trunk {
                for i in 0..trunk {
                    system.trunk_h[(i, j)] += columns(dome, i, j) * w_dome;
                }
                system.trunk_g[j] += along(dome, j, e) * w_dome;
            }
            system.fingers.push(FingerBlock::default());
            let block = &mut system.fingers[finger];
            self.fill_finger(finger, jacobian, error, &posture, w_dome, block);
        }
        system
    }

    fn fill_finger(
        &self,
        finger: usize,
        jacobian: &HandJacobian,
        error: &TaskError,
        posture: &PostureRows,
        w_dome: f64,
        block: &mut FingerBlock,
    ) {
        let own = self.finger_joints(finger);
        let of_tip = &jacobian.tips[finger];
        let (dome, tip) = (&of_tip.dome_axis, &of_tip.position);
        block.first_joint = own.start;
        block.joint_count = own.len();
        block.e = error.tip[finger];
        block.side = self.grasp_side(finger);
        for (row, joint) in own.clone().enumerate() {
            for (column, other) in own.clone().enumerate() {
                block.h[(row, column)] = columns(dome, joint, other) * w_dome;
            }
            block.h[(row, row)] += posture.h[joint];
            for trunk in self.trunk_joints() {
                block.cross[(row, trunk)] = columns(dome, joint, trunk) * w_dome;
            }
            block.g[row] = along(dome, joint, &error.dome_axis[finger]) * w_dome + posture.g[joint];
            block
                .tip_by_own
                .set_row(row, &tip.column(joint).transpose());
        }
        for trunk in self.trunk_joints() {
            let of_tip = tip.column(trunk).transpose();
            block.tip_by_trunk.set_row(trunk, &of_tip);
        }
    }

    /// Returns the diagonal of H and the part of g that pull towards the reference posture.
    fn posture_rows(&self, q: &HandVector, root_rad: f64, weights: &IkWeights) -> PostureRows {
        let mut weight = HandVector::repeat(self.joint_count, weights.posture * weights.posture);
        let mut wanted = self.reference;
        for root in self.tilting_joints() {
            weight[root] = weights.root_posture * weights.root_posture;
            wanted[root] = root_rad;
        }
        for lone in self.lone_joints() {
            weight[lone] = weights.lone_posture * weights.lone_posture;
        }
        let mut rows = PostureRows {
            h: weight.map(|weight| weight + weights.damping * weights.damping),
            g: (wanted - *q).zip_map(&weight, |off, weight| weight * off) * weights.secondary_gain,
        };
        for (index, joint) in self.joints().iter().enumerate() {
            let radian = joint.radian();
            rows.h[index] /= radian * radian;
            rows.g[index] /= radian * radian;
        }
        rows
    }

    /// Returns q + dq, clamped against rounding beyond a limit.
    fn advance(&self, q: &HandVector, dq: &HandVector) -> HandVector {
        HandVector::from_fn(self.joint_count, |index| {
            let (joint, q) = (&self.joints[index], q[index]);
            (q + dq[index]).clamp(joint.lower.min(q), joint.upper.max(q))
        })
    }
}

struct PostureRows {
    h: HandVector,
    g: HandVector,
}

/// Returns the product of two columns.
fn columns(rows: &Rows3, i: usize, j: usize) -> f64 {
    let (a, b) = (rows.column(i), rows.column(j));
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// Returns the product of a column with a vector.
fn along(rows: &Rows3, joint: usize, vector: &Vector3<f64>) -> f64 {
    let column = rows.column(joint);
    column.x * vector.x + column.y * vector.y + column.z * vector.z
}

impl TaskError {
    /// Returns `None` if the target or the pose is not finite, or their distance overflows.
    fn new(
        hand: &HandModel,
        pose: &HandPose,
        target: &HandTarget,
        weights: &IkWeights,
    ) -> Option<TaskError> {
        if !target.is_finite() {
            return None;
        }
        let fingers = pose.base_from_tip().len();
        let mut tip = [Vector3::zeros(); FINGERTIPS_MAX];
        let mut dome_axis = tip;
        for finger in 0..fingers {
            tip[finger] = target.tip_m[finger] - pose.tip_m(finger);
            dome_axis[finger] = target.dome_axis[finger] - pose.dome_axis(finger);
            if !tip[finger].norm().is_finite() {
                return None;
            }
        }
        let tip_error_m = hand.side_error_m(|finger| tip[finger]);
        let shorten = if tip_error_m > weights.tip_step_max_m {
            weights.tip_step_max_m / tip_error_m
        } else {
            1.0
        };
        let gain = weights.secondary_gain;
        Some(TaskError {
            tip: tip.map(|error| error * shorten),
            dome_axis: dome_axis.map(|error| error * gain),
            hand_axis: (target.hand_axis - pose.hand_axis()) * gain,
            tip_error_m,
        })
    }
}

/// Solves; holds the joints that left the box at its edge; solves the others again; clamps the
/// rest.
fn solve_in_box(system: &mut ArrowSystem, step_box: &StepBox) -> Option<(HandVector, IkStatus)> {
    let joints = step_box.lower.len();
    let mut held = [false; HAND_JOINTS_MAX];
    let mut status = IkStatus::Free;
    let mut dq = system.solve(joints)?;
    for pass in 1..=ACTIVE_SET_PASSES {
        if !dq.iter().all(|value| value.is_finite()) {
            return None;
        }
        let mut changed = false;
        for joint in 0..joints {
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
            dq = system.solve(joints)?;
        }
    }
    let clamped = HandVector::from_fn(joints, |joint| {
        dq[joint].clamp(step_box.lower[joint], step_box.upper[joint])
    });
    Some((clamped, status))
}
