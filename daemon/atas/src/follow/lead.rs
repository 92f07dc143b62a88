//! A target as one hand understands it now: the pose, with the yaw that the wrist reaches from where it is.

use super::targets::CheckedTarget;
use core::f64::consts::{FRAC_PI_2, PI};
use nalgebra::Vector3;
use robot_model::{GraspFrame, HandModel, VIRTUAL_FINGERS};
use shm_schemas::GripOrder;

/// Farthest turn of the wrist, rad (ours: 100°, a little more than the quarter turn that every closing axis needs, so that a
/// target near a quarter turn does not turn the hand around; the joint ends at 120°).
const ROLL_MAX_RAD: f64 = 100.0 * PI / 180.0;
/// Least opening of each finger that is led, m (ours: nearer, the fingertips would press each other).
const HALF_MIN_M: f64 = 0.002;

/// What the hand is wanted to do in this tick.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Lead {
    /// Where it shall be. Its fingers are opened as wanted, or as they are if something shall be held.
    pub frame: GraspFrame,
    /// What its fingers shall do.
    pub grip: GripOrder,
}

impl Lead {
    /// A target for a hand that is at `now`.
    #[must_use]
    pub fn of(hand: &HandModel, now: &GraspFrame, target: &CheckedTarget) -> Self {
        let centre_m = Vector3::from(target.centre_m());
        let yaw_rad = nearest_yaw_rad(hand, now, &centre_m, target.closing_yaw_rad());
        let half_opening_m = match target.grip() {
            GripOrder::HOLD => now.half_opening_m,
            _ => [(target.opening_m() / 2.0).max(HALF_MIN_M); VIRTUAL_FINGERS],
        };
        let frame = GraspFrame {
            hand_azimuth_rad: hand.bearing_rad(&now.centre_m),
            half_opening_m,
            ..GraspFrame::from_above(centre_m, yaw_rad, 0.0)
        };
        Self {
            frame,
            grip: target.grip(),
        }
    }

    /// Distance between the fingertips that is wanted, m.
    #[must_use]
    pub fn opening_m(&self) -> f64 {
        self.frame.half_opening_m.iter().sum()
    }
}

/// Of the yaws that hold an object the same way, the one that is nearest to where the hand is turned and that its wrist reaches.
fn nearest_yaw_rad(
    hand: &HandModel,
    now: &GraspFrame,
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
