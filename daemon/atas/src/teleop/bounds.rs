//! Teleoperation workspace: the hand's own side of the table.
//!
//! A goal's paths are checked against the other arm before motion; a stream's future is unknown.
//! Instead, a box bounds every target, and the [limiter](super::MotionLimiter) stays within it.
//! With the grasp centre in its box, no body of an arm reaches the middle plane. Both arms start on
//! their own sides ([`arm_across_middle`]), so they stay apart without collision checks in the
//! tick. The box also keeps fingertips off the table.

use nalgebra::Vector3;
use robot_model::{HandModel, HandSide, HandVector, RobotModel};
use shm_schemas::{Hand, Reason};

/// Smallest distance of a grasp centre from the middle plane, m. Design choice: with wide fingers
/// along y, the knuckles stay [`MIDDLE_CLEARANCE_M`] away (tested in
/// `tests/atas/motion_limiter.rs`).
const CENTRE_Y_MIN_M: f64 = 0.11;
/// Smallest distance of an arm from the middle plane, m. Design choice: half the clearance of the
/// arms in an accepted goal.
pub(super) const MIDDLE_CLEARANCE_M: f64 = 0.003;

/// Teleoperation workspace of one hand.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TeleopWorkspace {
    /// Range of x, y and z of the grasp centre, m.
    pub centre_m: [[f64; 2]; 3],
    /// Range of the distance between the fingertips, m.
    pub opening_m: [f64; 2],
}

impl TeleopWorkspace {
    /// Returns the workspace in the robot file, limited to the own side if there is another arm.
    /// `None` without one.
    #[must_use]
    pub fn new(robot: &RobotModel, side: HandSide) -> Option<Self> {
        let workspace = robot.hand(side).workspace()?;
        let [least_m, most_m] = workspace.y_m;
        let y_m = match side {
            _ if robot.sides().count() == 1 => [least_m, most_m],
            HandSide::Right => [least_m, most_m.min(-CENTRE_Y_MIN_M)],
            HandSide::Left => [least_m.max(CENTRE_Y_MIN_M), most_m],
        };
        let [_, widest_m] = workspace.opening_m;
        Some(Self {
            centre_m: [workspace.x_m, y_m, workspace.z_m],
            opening_m: [0.0, widest_m],
        })
    }
}

/// Returns the reason if this posture prevents teleoperation: the arm reaches across the middle.
#[must_use]
pub fn arm_across_middle(hand: &HandModel, q: &HandVector) -> Option<Reason> {
    let sign = hand.side().y_sign();
    // NaN counts as across the middle.
    let off_m = |end_m: &Vector3<f64>, radius_m: f64| {
        let off_m = sign * end_m.y - radius_m;
        if off_m.is_nan() {
            f64::NEG_INFINITY
        } else {
            off_m
        }
    };
    let nearest_m = hand
        .capsules(&hand.forward(q))
        .iter()
        .flat_map(|body| {
            [
                off_m(&body.a_m, body.radius_m),
                off_m(&body.b_m, body.radius_m),
            ]
        })
        .fold(f64::INFINITY, f64::min);
    let clear = nearest_m >= MIDDLE_CLEARANCE_M;
    (!clear).then(|| Reason::AcrossTheMiddle {
        hand: Hand::BOTH[hand.side().index()],
        gap_m: nearest_m,
        limit_m: MIDDLE_CLEARANCE_M,
    })
}
