//! Jacobians of one hand, and the compliance of its tips that follows from them.

use arrayvec::ArrayVec;
use nalgebra::{ArrayStorage, Matrix3, SMatrix, Vector3};

use crate::forward::HandPose;
use crate::model::{HandModel, Mover};
use crate::sizes::{FINGERTIPS_MAX, HAND_JOINTS_MAX};
use crate::vector::HandVector;

/// One direction or position of the hand per motion of each joint; columns beyond the last joint
/// are zero.
pub type Rows3 = SMatrix<f64, 3, HAND_JOINTS_MAX>;

const ZERO: Rows3 = Rows3::from_array_storage(ArrayStorage([[0.0; 3]; HAND_JOINTS_MAX]));

/// Geometric Jacobians of one fingertip in the base frame. Columns of joints that do not move it
/// are zero.
#[derive(Clone, Debug, PartialEq)]
pub struct TipJacobian {
    /// Position of the tip, metres per radian.
    pub position: Rows3,
    /// Dome axis (change of a unit vector), per radian.
    pub dome_axis: Rows3,
    /// Angular velocity, radians per radian.
    pub angular: Rows3,
}

/// Geometric Jacobians of one hand in the base frame.
#[derive(Clone, Debug, PartialEq)]
pub struct HandJacobian {
    /// Jacobians of each fingertip.
    pub tips: ArrayVec<TipJacobian, FINGERTIPS_MAX>,
    /// Hand axis (change of a unit vector), per radian.
    pub hand_axis: Rows3,
    joint_count: usize,
}

impl TipJacobian {
    /// Jacobians of a tip without joints.
    const STILL: TipJacobian = TipJacobian {
        position: ZERO,
        dome_axis: ZERO,
        angular: ZERO,
    };
}

impl HandModel {
    /// Computes the Jacobians at a pose.
    #[must_use]
    pub fn jacobian(&self, pose: &HandPose) -> HandJacobian {
        let mut jacobian = HandJacobian {
            tips: ArrayVec::new(),
            hand_axis: ZERO,
            joint_count: self.joint_count,
        };
        for frame in &self.frames[..self.arm_joints] {
            let mover = &frame.mover;
            if !mover.slides {
                let turned = pose.frame_axis(mover.frame).cross(&pose.hand_axis());
                add(&mut jacobian.hand_axis, mover.joint, turned * mover.ratio);
            }
        }
        for finger in 0..self.finger_count {
            jacobian.tips.push(TipJacobian::STILL);
            self.fill_tip(pose, finger, &mut jacobian.tips[finger]);
        }
        jacobian
    }

    fn fill_tip(&self, pose: &HandPose, finger: usize, of_tip: &mut TipJacobian) {
        for mover in self.movers(finger) {
            let moved = pose.tip_moved_by(finger, mover);
            add(&mut of_tip.position, mover.joint, moved);
            if !mover.slides {
                let axis = pose.frame_axis(mover.frame) * mover.ratio;
                let turned = axis.cross(&pose.dome_axis(finger));
                add(&mut of_tip.dome_axis, mover.joint, turned);
                add(&mut of_tip.angular, mover.joint, axis);
            }
        }
    }
}

impl HandPose {
    /// Returns the motion of a fingertip per motion of a mover, base frame: metres per radian, or
    /// per metre.
    #[must_use]
    pub fn tip_moved_by(&self, finger: usize, mover: &Mover) -> Vector3<f64> {
        let axis = self.frame_axis(mover.frame) * mover.ratio;
        if mover.slides {
            axis
        } else {
            axis.cross(&(self.tip_m(finger) - self.frame_origin_m(mover.frame)))
        }
    }
}

/// Adds to a column. Joints that mimic another joint add to the column of that joint.
fn add(rows: &mut Rows3, joint: usize, by: Vector3<f64>) {
    let mut column = rows.column_mut(joint);
    column += by;
}

impl HandJacobian {
    /// Returns the joint torques of a force on each tip, base frame: Jᵀ·F, N·m.
    #[must_use]
    pub fn torques_n_m(&self, forces_n: &[Vector3<f64>; FINGERTIPS_MAX]) -> HandVector {
        HandVector::from_fn(self.joint_count, |joint| {
            let tips = self.tips.iter().zip(forces_n);
            tips.fold(0.0, |sum, (tip, force_n)| {
                let column = tip.position.column(joint);
                sum + column.x * force_n.x + column.y * force_n.y + column.z * force_n.z
            })
        })
    }

    /// Returns the motion of these rows for a change of the joints.
    #[must_use]
    pub fn moved(rows: &Rows3, dq: &HandVector) -> Vector3<f64> {
        let joints = dq.iter().enumerate();
        joints.fold(Vector3::zeros(), |sum: Vector3<f64>, (joint, dq)| {
            sum + rows.column(joint) * *dq
        })
    }

    /// Computes the compliance of each tip, C = J·K⁻¹·Jᵀ, metres per newton, for joint stiffnesses
    /// K in newton metres per radian. A force F moves the tip by C·F.
    ///
    /// `None` if a stiffness is not finite and positive. Source: `C = J·K⁻¹·Jᵀ` of joint-stiffness
    /// control (Salisbury 1980); used to feed forward the vertical sag of a squeezing finger.
    #[must_use]
    pub fn tip_compliance(
        &self,
        stiffness: &HandVector,
    ) -> Option<ArrayVec<Matrix3<f64>, FINGERTIPS_MAX>> {
        if !stiffness.iter().all(|k| k.is_finite() && *k > 0.0) {
            return None;
        }
        let compliance = |tip: &TipJacobian| {
            let joints = stiffness.iter().enumerate();
            joints.fold(Matrix3::zeros(), |sum: Matrix3<f64>, (joint, stiffness)| {
                let column = tip.position.column(joint);
                sum + column * column.transpose() / *stiffness
            })
        };
        Some(self.tips.iter().map(compliance).collect())
    }
}
