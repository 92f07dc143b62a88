//! Rotation of a hand that points down about the vertical: by the arm's first joint, by its last,
//! or not at all.

use core::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Vector3;

use crate::model::HandModel;
use crate::turning::Turn;
use crate::vector::HandVector;

/// Smallest cosine between two axes that count as parallel.
const PARALLEL_COS: f64 = 0.999;
/// Tolerance around whole quarter turns, rad: rounding.
const ROUNDING_RAD: f64 = 1e-9;

impl HandModel {
    /// Determines from the reference posture how the hand turns.
    pub(crate) fn find_turning(&mut self) {
        let pose = self.forward(&self.reference);
        let turns_about = |joint: usize, axis: Vector3<f64>| {
            let frame = &self.frames[joint].mover;
            let cos = pose.frame_axis(joint).dot(&axis);
            (!frame.slides && libm::fabs(cos) > PARALLEL_COS).then(|| libm::copysign(1.0, cos))
        };
        let arm = self.arm_joints;
        let middle_m = pose.middle_m();
        let closing = pose.across_m();
        if let Some(sign) = turns_about(0, Vector3::z()).filter(|_| arm > 0) {
            let from_shoulder = middle_m - self.shoulder_m();
            let bearing_rad = libm::atan2(from_shoulder.y, from_shoulder.x);
            let zero_rad = snapped(self.reference[0] - sign * bearing_rad);
            self.turning.base = Some(Turn { sign, zero_rad });
        }
        // The roll at the reference posture counts as zero, so the yaw contains the rest.
        let roll = (arm > 1).then(|| turns_about(arm - 1, pose.hand_axis()));
        let yaw_rad = libm::atan2(closing.y, closing.x) - self.bearing_rad(&middle_m);
        self.turning.wrist = roll.flatten().map(|sign| Turn {
            sign,
            zero_rad: snapped(self.reference[arm - 1]),
        });
        self.turning.yaw_rad = snapped(wrapped(yaw_rad));
    }

    /// Direction from the shoulder to a point in the horizontal plane, radians, if the arm's first
    /// joint turns it about the vertical, else 0: a hand of such an arm that points down keeps its
    /// closing yaw wherever it is.
    #[must_use]
    pub fn bearing_rad(&self, point_m: &Vector3<f64>) -> f64 {
        if self.turning.base.is_none() {
            return 0.0;
        }
        let from_shoulder = point_m - self.shoulder_m();
        libm::atan2(from_shoulder.y, from_shoulder.x)
    }

    /// Returns the closing yaw of a hand over `centre_m` that points down in this posture, up to
    /// whole turns, radians.
    #[must_use]
    pub fn yaw_of_joints_rad(&self, q: &HandVector, centre_m: &Vector3<f64>) -> f64 {
        let roll_rad = self.turning.wrist.map_or(0.0, |wrist| {
            let angle_rad = self.arm_joints.checked_sub(1).map_or(0.0, |last| q[last]);
            wrist.sign * (angle_rad - wrist.zero_rad)
        });
        self.bearing_rad(centre_m) + self.turning.yaw_rad - roll_rad
    }

    /// Turns the arm of a posture towards a point and its wrist to a closing yaw, if it has such
    /// joints.
    pub(crate) fn turn_towards(
        &self,
        q: &mut HandVector,
        centre_m: &Vector3<f64>,
        closing_yaw_rad: f64,
    ) {
        if let Some(base) = self.turning.base {
            q[0] = base.sign * self.bearing_rad(centre_m) + base.zero_rad;
        }
        if let Some(wrist) = self.turning.wrist {
            let roll_rad = self.wrist_roll_rad(centre_m, closing_yaw_rad);
            q[self.arm_joints - 1] = wrist.sign * roll_rad + wrist.zero_rad;
        }
    }

    /// Returns the wrist roll in (−180°, 180°] that gives a hand that points down over `centre_m`
    /// the closing yaw.
    fn wrist_roll_rad(&self, centre_m: &Vector3<f64>, closing_yaw_rad: f64) -> f64 {
        wrapped(self.bearing_rad(centre_m) + self.turning.yaw_rad - closing_yaw_rad)
    }

    /// Returns the equivalent closing yaw that keeps the wrist roll within ±90°, radians. An object
    /// can be held at a yaw or at yaw + 180° (sides exchanged). For a move, pass the centre at
    /// mid-path, so that the choice holds from start to end.
    ///
    /// ```
    /// # #[cfg(feature = "std")] {
    /// # use nalgebra::Vector3;
    /// # use robot_model::{HandSide, RobotModel};
    /// let robot = RobotModel::two_hand_arm()?;
    /// let hand = robot.hand(HandSide::Right);
    /// let centre_m = Vector3::new(0.3, -0.1, 0.05);
    /// // Both yaws hold the object; one of them keeps the wrist within its range.
    /// let yaw_rad = hand.closing_yaw_rad(&centre_m, 0.2);
    /// assert!(yaw_rad == 0.2 || yaw_rad == 0.2 + std::f64::consts::PI);
    /// # }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn closing_yaw_rad(&self, centre_m: &Vector3<f64>, closing_yaw_rad: f64) -> f64 {
        let roll = self.wrist_roll_rad(centre_m, closing_yaw_rad);
        if libm::fabs(roll) <= FRAC_PI_2 {
            closing_yaw_rad
        } else {
            closing_yaw_rad + PI
        }
    }
}

/// Wraps an angle to (−180°, 180°].
fn wrapped(angle_rad: f64) -> f64 {
    angle_rad - 2.0 * PI * libm::round(angle_rad / (2.0 * PI))
}

/// Removes rounding near whole quarter turns.
fn snapped(angle_rad: f64) -> f64 {
    let quarters = libm::round(angle_rad / FRAC_PI_2) * FRAC_PI_2;
    if libm::fabs(angle_rad - quarters) < ROUNDING_RAD {
        quarters
    } else {
        angle_rad
    }
}
