//! Fingertips and closing axes of a robot at given joint positions.

use nalgebra::Vector3;
use robot_model::{GraspSide, HandModel, HandPose, HandVector, RobotModel};

use super::bodies::{Body, Shade};
use super::mark::{Drawing, Mark, Rgb};
use super::view::{Sheet, View};

/// Colour of fingertips: green, distinct from the links for any colour vision (Okabe and Ito).
pub(super) const FINGERTIP_RGB: Rgb = [0, 158, 115];
/// Colour of closing axes.
pub(super) const AXIS_RGB: Rgb = [213, 94, 0];
/// Thickness of a flat or bent fingertip sensor, m (design choice: visible from the side).
const PAD_M: f64 = 0.003;
/// Length of the closing axis beyond the fingertips, m (design choice).
const BEYOND_M: f64 = 0.03;
/// Growth of a dome over its link's shape of equal size, so that the dome is seen.
const DOME_GROWTH: f64 = 1.04;

/// Returns the poses of the hands that the robot has.
pub(super) fn poses<'a>(robot: &'a RobotModel, q: &[f64]) -> Vec<(&'a HandModel, HandPose)> {
    let pose = |side| {
        let (hand, range) = (robot.hand(side), robot.joint_range(side));
        let own = q.get(range)?;
        Some((hand, hand.forward(&HandVector::from_slice(own))))
    };
    robot.sides().filter_map(pose).collect()
}

/// Returns the sensing faces of all fingertips: domes as balls, pads as slabs.
pub(super) fn fingertips(robot: &RobotModel, q: &[f64]) -> Vec<Body> {
    let hands = poses(robot, q);
    let tips = hands.iter().flat_map(|(hand, pose)| {
        (0..hand.fingertip_count()).map(move |finger| fingertip(hand, pose, finger))
    });
    tips.collect()
}

fn fingertip(hand: &HandModel, pose: &HandPose, finger: usize) -> Body {
    let named = hand.skin().layout;
    let layout = named.layout();
    // Elements at unknown positions have no outline.
    if named.is_dome() || layout.count < 3 || is_line(&layout.position_m[..layout.count]) {
        let radius_m = DOME_GROWTH * hand.tip_radius_m()[finger];
        return Body::ball(pose.tip_m(finger), radius_m, FINGERTIP_RGB);
    }
    let frame = pose.base_from_tip()[finger];
    let faces = [0.0, PAD_M].into_iter().flat_map(|below_m| {
        layout.position_m[..layout.count].iter().map(move |at_m| {
            let [x, y, z] = *at_m;
            frame.point(&Vector3::new(x, y, z - below_m)).into()
        })
    });
    Body {
        corners: faces.collect(),
        half_m: 0.0,
        rgb: FINGERTIP_RGB,
        shade: Shade::Plain,
    }
}

/// Returns true if the positions do not span an area.
fn is_line(position_m: &[[f64; 3]]) -> bool {
    let across = |axis: usize| {
        let values = || position_m.iter().map(|at| at[axis]);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    across(0) <= 0.0 || across(1) <= 0.0
}

/// Draws the closing axis of each hand: from one grasp side through the other.
pub(super) fn draw_closing_axes(
    drawing: &mut Drawing,
    view: &View,
    sheet: &Sheet,
    robot: &RobotModel,
    q: &[f64],
) {
    for (_, pose) in poses(robot, q) {
        let [a, b] = GraspSide::BOTH.map(|side| pose.side_m(side));
        let Some(along) = (b - a).try_normalize(1e-9) else {
            continue;
        };
        let ends = [a - along * BEYOND_M, b + along * BEYOND_M];
        drawing.marks.push(Mark::Line {
            ends: ends.map(|end| sheet.place(view.plane_m(&end.into()))),
            width: 1.5,
            colour: AXIS_RGB,
            is_dashed: true,
        });
    }
}
