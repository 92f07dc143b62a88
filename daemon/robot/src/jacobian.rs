//! Jacobians of one hand, and the compliance of its tips that follows from them.

use nalgebra::{Matrix3, SMatrix, Vector3};

use crate::forward::HandPose;
use crate::model::{HandModel, finger_root};
use crate::sizes::{ARM_JOINTS, FINGER_JOINTS, FINGERS, HAND_JOINTS, HandVector};

/// 3 × 11: one direction or position of the hand per radian of each joint.
pub type Rows3 = SMatrix<f64, 3, HAND_JOINTS>;
/// 6 × 11: finger 1 in rows 0–2, finger 2 in rows 3–5.
pub type Rows6 = SMatrix<f64, 6, HAND_JOINTS>;

/// Geometric Jacobians of one hand in the base frame. Columns of joints that do not move a row's object are zero.
#[derive(Clone, Debug, PartialEq)]
pub struct HandJacobian {
    /// Tip positions, metres per radian.
    pub tip: Rows6,
    /// Dome axes (change of a unit vector), per radian.
    pub dome_axis: Rows6,
    /// Hand axis (change of a unit vector), per radian.
    pub hand_axis: Rows3,
    /// Angular velocity of each tip, radians per radian.
    pub tip_angular: [Rows3; FINGERS],
}

impl HandModel {
    /// Jacobians at a pose.
    #[must_use]
    pub fn jacobian(&self, pose: &HandPose) -> HandJacobian {
        let mut jacobian = HandJacobian {
            tip: Rows6::zeros(),
            dome_axis: Rows6::zeros(),
            hand_axis: Rows3::zeros(),
            tip_angular: [Rows3::zeros(); FINGERS],
        };
        for joint in 0..ARM_JOINTS {
            let hand_axis = pose.joint_axis(joint).cross(&pose.hand_axis());
            jacobian.hand_axis.set_column(joint, &hand_axis);
        }
        for finger in 0..FINGERS {
            for joint in chain(finger) {
                jacobian.set_finger_column(pose, finger, joint);
            }
        }
        jacobian
    }
}

/// The joints that move a finger's tip: the arm's and its own.
fn chain(finger: usize) -> impl Iterator<Item = usize> {
    let root = finger_root(finger);
    (0..ARM_JOINTS).chain(root..root + FINGER_JOINTS)
}

impl HandJacobian {
    fn set_finger_column(&mut self, pose: &HandPose, finger: usize, joint: usize) {
        let axis = pose.joint_axis(joint);
        let lever_m = pose.tip_m(finger) - pose.joint_origin_m(joint);
        let set = |rows: &mut Rows6, value: Vector3<f64>| {
            rows.fixed_view_mut::<3, 1>(3 * finger, joint)
                .copy_from(&value);
        };
        set(&mut self.tip, axis.cross(&lever_m));
        set(&mut self.dome_axis, axis.cross(&pose.dome_axis(finger)));
        self.tip_angular[finger].set_column(joint, &axis);
    }

    /// Compliance of each tip, C = J·K⁻¹·Jᵀ, metres per newton, for joint stiffnesses K in newton metres per radian:
    /// a force F on the tip moves it by C·F.
    ///
    /// `None` if a stiffness is not finite and positive. Source: `C = J·K⁻¹·Jᵀ` of joint-stiffness control (Salisbury
    /// 1980); used to feed forward the vertical sag of a squeezing finger.
    #[must_use]
    pub fn tip_compliance(
        &self,
        stiffness_n_m_rad: &HandVector,
    ) -> Option<[Matrix3<f64>; FINGERS]> {
        if !stiffness_n_m_rad.iter().all(|k| k.is_finite() && *k > 0.0) {
            return None;
        }
        let compliance = |finger: usize| {
            chain(finger).fold(Matrix3::zeros(), |sum: Matrix3<f64>, joint| {
                let column = self.tip.fixed_view::<3, 1>(3 * finger, joint);
                sum + column * column.transpose() / stiffness_n_m_rad[joint]
            })
        };
        Some([compliance(0), compliance(1)])
    }
}
