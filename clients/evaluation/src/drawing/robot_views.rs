//! Front, side and top view of a robot in its rest pose, with legend and scale.

use nalgebra::Vector3;
use robot_model::{ModelError, RobotFiles, RobotModel, RobotVector};

use super::bodies::{Body, Links};
use super::hands::{AXIS_RGB, FINGERTIP_RGB, draw_closing_axes, fingertips};
use super::mark::{Drawing, INK, Mark};
use super::view::{Sheet, View};

/// Scale of the drawing, pixels per metre, and the margin around each view, px.
const PX_PER_M: f64 = 420.0;
const MARGIN_PX: f64 = 24.0;
/// Height of the legend below the views, px.
const LEGEND_PX: f64 = 34.0;
/// Length of the scale, m.
const SCALE_M: f64 = 0.1;

/// Directions to the right and upwards in each view, base frame.
const VIEWS: [(&str, [f64; 3], [f64; 3]); 3] = [
    ("front", [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]),
    ("side", [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
    ("above", [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]),
];

/// Draws a robot with its fingertips and closing axes. Also returns one sentence for each mesh that
/// is not drawn.
///
/// # Errors
/// The URDF is not a tree of links, or a number in it is not finite.
pub fn robot_views(
    files: &RobotFiles,
    robot: &RobotModel,
) -> Result<(Drawing, Vec<String>), ModelError> {
    let q = rest_posture(robot);
    let links = Links::load(files)?;
    let mut bodies = links.bodies(&q);
    bodies.extend(fingertips(robot, &q));
    let mut drawing = Drawing::default();
    for (name, right, up) in VIEWS {
        let view = View {
            right: right.into(),
            up: up.into(),
        };
        let drawn = one_view(name, &view, &bodies, robot, &q);
        drawing.append_at(drawing.size_px[0], drawn);
    }
    add_legend(&mut drawing);
    Ok((drawing, links.meshes().remarks.clone()))
}

/// Returns the joint positions of the rest pose: home if the hands reach it, else the reference
/// posture.
fn rest_posture(robot: &RobotModel) -> RobotVector {
    sim_backend::home(robot).unwrap_or_else(|_| {
        let mut rest_rad = RobotVector::zeros(robot.joint_count());
        for side in robot.sides() {
            rest_rad[robot.joint_range(side)].copy_from_slice(robot.hand(side).reference());
        }
        rest_rad
    })
}

fn one_view(
    name: &str,
    view: &View,
    bodies: &[Body],
    robot: &RobotModel,
    q: &RobotVector,
) -> Drawing {
    // The view contains the origin of the base frame.
    let [low, high] = view.bounds_m(bodies);
    let (low, high) = (low.map(|at| at.min(0.0)), high.map(|at| at.max(0.0)));
    let sheet = Sheet {
        px_per_m: PX_PER_M,
        corner_m: [low[0], high[1]],
        corner_px: [MARGIN_PX, 2.0 * MARGIN_PX],
    };
    let mut drawing = Drawing {
        size_px: [
            (high[0] - low[0]) * PX_PER_M + 2.0 * MARGIN_PX,
            (high[1] - low[1]) * PX_PER_M + 3.0 * MARGIN_PX,
        ],
        marks: Vec::new(),
    };
    drawing.add_text([MARGIN_PX, MARGIN_PX], name);
    if view.up == Vector3::z() {
        let ends = [[low[0], 0.0], [high[0], 0.0]].map(|end| sheet.place(end));
        drawing.marks.push(Mark::Line {
            ends,
            width: 1.0,
            colour: [187; 3],
            is_dashed: true,
        });
    }
    view.draw(&mut drawing, &sheet, bodies);
    draw_closing_axes(&mut drawing, view, &sheet, robot, q);
    drawing
}

/// Adds scale, fingertip and closing axis with their names.
fn add_legend(drawing: &mut Drawing) {
    let y = drawing.size_px[1] + LEGEND_PX / 2.0 - MARGIN_PX / 2.0;
    let x = MARGIN_PX;
    let end = x + SCALE_M * PX_PER_M;
    drawing.add_line([[x, y], [end, y]], 2.0, INK);
    for tick in [x, end] {
        drawing.add_line([[tick, y - 4.0], [tick, y + 4.0]], 1.0, INK);
    }
    drawing.add_text([end + 8.0, y + 4.0], "100 mm");
    drawing.marks.push(Mark::Disc {
        centre: [x + 130.0, y],
        radius: 6.0,
        fill: FINGERTIP_RGB,
    });
    drawing.add_text([x + 142.0, y + 4.0], "fingertip");
    drawing.marks.push(Mark::Line {
        ends: [[x + 220.0, y], [x + 250.0, y]],
        width: 1.5,
        colour: AXIS_RGB,
        is_dashed: true,
    });
    drawing.add_text([x + 258.0, y + 4.0], "closing axis");
    drawing.size_px[0] = drawing.size_px[0].max(x + 360.0);
    drawing.size_px[1] += LEGEND_PX;
}
