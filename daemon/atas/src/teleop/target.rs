//! Teleoperation target of one hand: pose with a yaw that the wrist can reach from its present
//! angle.

use super::targets::ValidatedTarget;
use core::f64::consts::{FRAC_PI_2, PI};
use nalgebra::Vector3;
use robot_model::{GraspPose, HandModel, PerSide};
use shm_schemas::GripOrder;

/// Largest wrist rotation, rad. Design choice: slightly more than the quarter turn that covers
/// every closing axis, so that a target near a quarter turn does not flip the hand; the joint ends
/// at 120°.
const ROLL_MAX_RAD: f64 = 100.0 * PI / 180.0;
/// Smallest commanded opening per side, m. Design choice: below it the fingertips press each other.
const HALF_OPENING_MIN_M: f64 = 0.002;

/// Requested state of a hand in this tick.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TeleopTarget {
    /// Target pose; its opening is the requested one, or the present one while holding.
    pub pose: GraspPose,
    /// Grip command.
    pub grip: GripOrder,
}

impl TeleopTarget {
    /// Creates the target of a hand at pose `now`.
    #[must_use]
    pub fn new(hand: &HandModel, now: &GraspPose, target: &ValidatedTarget) -> Self {
        let centre_m = Vector3::from(target.centre_m());
        let yaw_rad = nearest_yaw_rad(hand, now, &centre_m, target.closing_yaw_rad());
        let half_opening_m = match target.grip() {
            GripOrder::HOLD => now.half_opening_m,
            _ => PerSide::repeat((target.opening_m() / 2.0).max(HALF_OPENING_MIN_M)),
        };
        let frame = GraspPose {
            hand_azimuth_rad: hand.bearing_rad(&now.centre_m),
            half_opening_m,
            ..GraspPose::from_above(centre_m, yaw_rad, 0.0)
        };
        Self {
            pose: frame,
            grip: target.grip(),
        }
    }

    /// Returns the requested distance between the fingertips, m.
    #[must_use]
    pub fn opening_m(&self) -> f64 {
        self.pose.half_opening_m.iter().sum()
    }
}

/// Returns the equivalent grasp yaw nearest to the present one that the wrist can reach, rad.
fn nearest_yaw_rad(
    hand: &HandModel,
    now: &GraspPose,
    centre_m: &Vector3<f64>,
    yaw_rad: f64,
) -> f64 {
    let half_turns = libm::round((yaw_rad - now.closing_yaw_rad) / PI);
    let nearest_rad = yaw_rad - half_turns * PI;
    let roll_rad = hand.bearing_rad(centre_m) + FRAC_PI_2 - nearest_rad;
    if roll_rad.abs() <= ROLL_MAX_RAD {
        nearest_rad
    } else {
        nearest_rad + PI * libm::round(roll_rad / PI)
    }
}
