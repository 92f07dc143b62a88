//! SVG drawing of a robot in its rest pose: front, side and top view.
//!
//! Visual shapes of the URDF are simplified: a cylinder becomes a thick line with round ends, a
//! sphere a circle, a box its outline. A link without such a shape becomes a line from its parent
//! link.

use std::fmt::Write;

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use robot_model::{
    Form, ModelError, Placement, RobotFiles, RobotModel, RobotVector, Shape, Skeleton,
};

/// Scale of the drawing, pixels per metre, and the margin around each view, px.
const PX_PER_M: f64 = 420.0;
const MARGIN_PX: f64 = 24.0;
const LINK_HALF_WIDTH_M: f64 = 0.004;

/// Directions to the right and upwards in each view, base frame.
const VIEWS: [(&str, [f64; 3], [f64; 3]); 3] = [
    ("front", [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]),
    ("side", [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
    ("above", [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]),
];

struct Stroke {
    ends: Vec<Point3<f64>>,
    half_m: f64,
    rgba: [f64; 4],
}

pub(super) fn draw(files: &RobotFiles, robot: &RobotModel) -> Result<String, ModelError> {
    let strokes = strokes(&files.skeleton()?, &rest_posture(robot));
    let mut x_px = 0.0;
    let (mut body, mut height_px) = (String::new(), 0.0_f64);
    for (name, right, up) in VIEWS {
        let (view, width, height) = view(name, &strokes, right.into(), up.into());
        // Writing into a string cannot fail.
        let _ = write!(body, "<g transform=\"translate({x_px:.1} 0)\">{view}</g>");
        x_px += width;
        height_px = height_px.max(height);
    }
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {x_px:.0} {height_px:.0}\" font-family=\"sans-serif\" \
         font-size=\"13\"><title>{}</title><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>{body}</svg>\n",
        files.name.replace('&', "&amp;").replace('<', "&lt;")
    ))
}

/// Returns the joint positions of the rest pose: home if the hands reach it, else the reference
/// posture.
fn rest_posture(robot: &RobotModel) -> RobotVector {
    sim_backend::home_rad(robot).unwrap_or_else(|_| {
        let mut rest_rad = RobotVector::zeros(robot.joint_count());
        for side in robot.sides() {
            rest_rad[robot.joint_range(side)].copy_from_slice(robot.hand(side).reference_rad());
        }
        rest_rad
    })
}

fn strokes(skeleton: &Skeleton, q_rad: &[f64]) -> Vec<Stroke> {
    let mut base_from: Vec<Isometry3<f64>> = Vec::new();
    let mut strokes = Vec::new();
    for limb in skeleton.limbs() {
        let parent = limb
            .parent
            .map_or(Isometry3::identity(), |index| base_from[index]);
        let here = parent * isometry(&limb.placed(q_rad));
        if limb.parent.is_some() && limb.shapes.is_empty() {
            let ends = [parent, here].map(|frame| Point3::from(frame.translation.vector));
            strokes.push(Stroke {
                ends: ends.to_vec(),
                half_m: LINK_HALF_WIDTH_M,
                rgba: [0.75, 0.75, 0.75, 1.0],
            });
        }
        strokes.extend(limb.shapes.iter().map(|shape| stroke(&here, shape)));
        base_from.push(here);
    }
    strokes
}

fn stroke(base_from_link: &Isometry3<f64>, shape: &Shape) -> Stroke {
    let frame = base_from_link * isometry(&shape.origin);
    let (ends, half_m) = match shape.form {
        Form::Sphere { radius_m } => (vec![Point3::origin()], radius_m),
        Form::Cylinder { radius_m, length_m } => {
            // Shortened by the radius: round line ends extend the cylinder.
            let half_m = (length_m / 2.0 - radius_m).max(0.0);
            let end = |sign: f64| Point3::new(0.0, 0.0, sign * half_m);
            (vec![end(-1.0), end(1.0)], radius_m)
        }
        Form::Box { size_m } => {
            let [x, y, z] = size_m.map(|edge_m| edge_m / 2.0);
            let signs = [-1.0, 1.0];
            let corner = |sx: f64, sy: f64, sz: f64| Point3::new(sx * x, sy * y, sz * z);
            let corners = signs.into_iter().flat_map(|sx| {
                signs
                    .into_iter()
                    .flat_map(move |sy| signs.into_iter().map(move |sz| corner(sx, sy, sz)))
            });
            (corners.collect(), 0.0)
        }
    };
    Stroke {
        ends: ends.iter().map(|end| frame * end).collect(),
        half_m,
        rgba: shape.rgba,
    }
}

fn view(
    name: &str,
    strokes: &[Stroke],
    right: Vector3<f64>,
    up: Vector3<f64>,
) -> (String, f64, f64) {
    let depth = right.cross(&up);
    let seen = |point: &Point3<f64>| [right.dot(&point.coords), up.dot(&point.coords)];
    let ends = strokes.iter().flat_map(|stroke| {
        let half_m = stroke.half_m;
        let at = stroke.ends.iter().map(seen);
        at.flat_map(move |[x, y]| [[x - half_m, y - half_m], [x + half_m, y + half_m]])
    });
    let start = [[0.0_f64; 2]; 2];
    let [low, high] = ends.fold(start, |[low, high], [x, y]| {
        [
            [low[0].min(x), low[1].min(y)],
            [high[0].max(x), high[1].max(y)],
        ]
    });
    let place = |[x, y]: [f64; 2]| {
        [
            (x - low[0]) * PX_PER_M + MARGIN_PX,
            (high[1] - y) * PX_PER_M + 2.0 * MARGIN_PX,
        ]
    };
    let mut order: Vec<&Stroke> = strokes.iter().collect();
    let nearness = |stroke: &Stroke| {
        let sum: f64 = stroke.ends.iter().map(|end| depth.dot(&end.coords)).sum();
        sum / stroke.ends.len().max(1) as f64
    };
    order.sort_by(|a, b| nearness(a).total_cmp(&nearness(b)));
    let mut svg = format!("<text x=\"{MARGIN_PX}\" y=\"{MARGIN_PX}\" fill=\"#444\">{name}</text>");
    if up.z > 0.0 {
        let [_, y] = place([0.0, 0.0]);
        let [left, width] = [place([low[0], 0.0])[0], place([high[0], 0.0])[0]];
        let _ = write!(
            svg,
            "<line x1=\"{left:.1}\" y1=\"{y:.1}\" x2=\"{width:.1}\" y2=\"{y:.1}\" stroke=\"#bbb\" stroke-dasharray=\"4 3\"/>"
        );
    }
    for stroke in order {
        let points: Vec<[f64; 2]> = stroke.ends.iter().map(|end| place(seen(end))).collect();
        draw_stroke(&mut svg, stroke, &points);
    }
    let [width, height] = [high[0] - low[0], high[1] - low[1]];
    (
        svg,
        width * PX_PER_M + 2.0 * MARGIN_PX,
        height * PX_PER_M + 3.0 * MARGIN_PX,
    )
}

fn draw_stroke(svg: &mut String, stroke: &Stroke, points: &[[f64; 2]]) {
    let [r, g, b, _] = stroke
        .rgba
        .map(|part| (part.clamp(0.0, 1.0) * 255.0).round());
    let colour = format!("rgb({r},{g},{b})");
    let thick_px = 2.0 * stroke.half_m * PX_PER_M;
    let _ = match points {
        [] => Ok(()),
        [[x, y]] => write!(
            svg,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.1}\" fill=\"{colour}\" stroke=\"#333\" stroke-width=\"0.5\"/>",
            thick_px / 2.0
        ),
        [[ax, ay], [bx, by]] => write!(
            svg,
            "<line x1=\"{ax:.1}\" y1=\"{ay:.1}\" x2=\"{bx:.1}\" y2=\"{by:.1}\" stroke=\"{colour}\" stroke-width=\"{thick_px:.1}\" \
             stroke-linecap=\"round\"/>"
        ),
        corners => {
            let outline: Vec<String> = hull(corners)
                .iter()
                .map(|[x, y]| format!("{x:.1},{y:.1}"))
                .collect();
            write!(
                svg,
                "<polygon points=\"{}\" fill=\"{colour}\" stroke=\"#333\" stroke-width=\"0.5\"/>",
                outline.join(" ")
            )
        }
    };
}

/// Returns the convex hull of the points (A. M. Andrew, 1979).
fn hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let turns = |o: [f64; 2], a: [f64; 2], b: [f64; 2]| {
        (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
    };
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while chain.len() > 1
                && turns(chain[chain.len() - 2], chain[chain.len() - 1], point) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut outline = half(&mut sorted.iter().copied());
    outline.extend(half(&mut sorted.iter().rev().copied()));
    outline
}

fn isometry(placement: &Placement) -> Isometry3<f64> {
    let rotation = Quaternion::from_vector(placement.rotation_xyzw.into());
    Isometry3::from_parts(
        Translation3::from(Vector3::from(placement.translation_m)),
        UnitQuaternion::new_normalize(rotation),
    )
}
