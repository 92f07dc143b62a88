//! Pinch pose: the point, direction and opening between the grasp sides of a posture.

use crate::grasp_sides::GraspSide;
use nalgebra::Vector3;

use crate::forward::HandPose;
use crate::model::HandModel;

/// Point, direction and distance between the two grasp sides of a posture.
///
/// Inverse of [`crate::GraspPose::from_above`]: clients that know joint positions, such as a
/// leader arm or a data set, obtain the target of teleoperation with it.
///
/// ```
/// use robot_model::{HandSide, RobotModel};
///
/// # fn main() -> Result<(), robot_model::ModelError> {
/// let robot = RobotModel::two_hand_arm()?;
/// let hand = robot.hand(HandSide::Right);
/// let posture = hand.forward(hand.reference());
/// let pinch = hand.pinch_pose(&posture);
/// // Equal fingertips: the point is the middle of both sides.
/// let middle_m = posture.middle_m();
/// assert!((pinch.centre_m - middle_m).norm() < 1e-9);
/// let distance_m = posture.across_m().norm();
/// assert!(0.0 < pinch.opening_m && pinch.opening_m < distance_m);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinchPose {
    /// Point between the grasp sides, base frame, metres.
    pub centre_m: Vector3<f64>,
    /// Direction of the closing axis in the horizontal plane, radians from the base's x.
    pub closing_yaw_rad: f64,
    /// Distance between the surfaces of the two sides, metres; negative if they overlap.
    pub opening_m: f64,
}

impl HandModel {
    /// Computes the pinch pose of a posture; not finite if a joint position is not.
    #[must_use]
    pub fn pinch_pose(&self, pose: &HandPose) -> PinchPose {
        let [first_m, second_m] = GraspSide::BOTH.map(|side| pose.side_m(side));
        let [first_radius_m, second_radius_m] = GraspSide::BOTH
            .map(|side| self.mean_of_side(side, |finger| self.tip_radius_m()[finger]));
        let between_m = first_m - second_m;
        let distance_m = between_m.norm();
        // The middle of the gap, which differs from the middle of the centres if one side's
        // fingertips are larger.
        let shift = if distance_m > 0.0 {
            (second_radius_m - first_radius_m) / (2.0 * distance_m)
        } else {
            0.0
        };
        PinchPose {
            centre_m: (first_m + second_m) / 2.0 + between_m * shift,
            closing_yaw_rad: libm::atan2(between_m.y, between_m.x),
            opening_m: distance_m - first_radius_m - second_radius_m,
        }
    }
}
