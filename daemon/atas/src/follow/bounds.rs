//! Where a client may lead a hand: its own side of the table.
//!
//! A goal's ways are compared with the other arm before anything moves; a stream's are not known. So a conservative bound
//! stands in for that check: two planes left and right of the middle that no body of an arm crosses as long as the centre of
//! its grasp keeps to a box. Both arms are on their sides when the stream opens ([`across_the_middle`]), the box bounds every
//! target and the [follower](super::Follower) never leaves the box between two of them, so the arms stay apart without looking
//! at bodies on the tick. The box also keeps fingertips off the table.

use nalgebra::Vector3;
use robot_model::{HandModel, HandVector, RobotModel, Side};
use shm_schemas::{Cause, Reason};

/// Nearest that a centre may come to the middle, m (ours: with fingers along y, opened wide, their knuckles then stay
/// [`MIDDLE_M`] away; `tests/atas/follow.rs` tries the box).
const NEAREST_Y_M: f64 = 0.11;
/// Distance of every body of an arm from the middle, m (ours: half of what an accepted goal keeps between the arms).
pub(super) const MIDDLE_M: f64 = 0.003;

/// The box of one hand.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FollowSpace {
    /// Least and greatest x, y and z of the centre, m.
    pub centre_m: [[f64; 2]; 3],
    /// Least and greatest distance between the fingertips, m.
    pub opening_m: [f64; 2],
}

impl FollowSpace {
    /// Where this hand may be led: in the workspace of its robot file, and beside another arm on its own side. `None` without
    /// a workspace.
    #[must_use]
    pub fn of(robot: &RobotModel, side: Side) -> Option<Self> {
        let workspace = robot.hand(side).workspace()?;
        let [least_m, most_m] = workspace.y_m;
        let y_m = match side {
            _ if robot.sides().count() == 1 => [least_m, most_m],
            Side::Right => [least_m, most_m.min(-NEAREST_Y_M)],
            Side::Left => [least_m.max(NEAREST_Y_M), most_m],
        };
        let [_, widest_m] = workspace.opening_m;
        Some(Self {
            centre_m: [workspace.x_m, y_m, workspace.z_m],
            opening_m: [0.0, widest_m],
        })
    }
}

/// Why a hand in this posture cannot begin to follow, or stand beside one that does: an arm reaches over the middle.
#[must_use]
pub fn across_the_middle(hand: &HandModel, q_rad: &HandVector) -> Option<Reason> {
    let sign = hand.side().y_sign();
    // What is not a number is nowhere near its side.
    let off_m = |end_m: &Vector3<f64>, radius_m: f64| {
        let off_m = sign * end_m.y - radius_m;
        if off_m.is_nan() {
            f64::NEG_INFINITY
        } else {
            off_m
        }
    };
    let nearest_m = hand
        .capsules(&hand.forward(q_rad))
        .iter()
        .flat_map(|body| {
            [
                off_m(&body.a_m, body.radius_m),
                off_m(&body.b_m, body.radius_m),
            ]
        })
        .fold(f64::INFINITY, f64::min);
    let clear = nearest_m >= MIDDLE_M;
    let reason = Reason::limit(Cause::ACROSS_THE_MIDDLE, nearest_m, MIDDLE_M);
    (!clear).then(|| reason.about(hand.side().index()))
}
