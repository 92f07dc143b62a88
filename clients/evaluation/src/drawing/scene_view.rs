//! View of the acting hand and the objects of a scene.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use robot_model::{Form, HandSide, RobotModel};
use shm_schemas::{ObjectTruth, WorldTruth};
use sim_backend::{Scene, Shape};

use super::bodies::{Body, Links, Shade, primitive};
use super::hands::{draw_closing_axes, fingertips};
use super::mark::{Drawing, EDGE, Mark, Rgb};
use super::view::{Sheet, View};

/// Direction of the view from the closing axis, and its height above the horizon, rad (design
/// choice: both fingertips and the lift are seen).
const AZIMUTH_RAD: f64 = -FRAC_PI_2 + 0.45;
const HEIGHT_RAD: f64 = 0.4;
/// Height of the picture around one object, m (design choice: the hand, the object and its lift).
const SPAN_M: f64 = 0.34;
/// Height of the middle of the picture above the table, m.
const MIDDLE_M: f64 = 0.085;
/// Half edge of the drawn part of the table, and the pitch of its grid, m.
const TABLE_M: f64 = 0.4;
const GRID_M: f64 = 0.1;
const TABLE_RGB: Rgb = [238, 240, 242];
const GRID_RGB: Rgb = [206, 210, 215];
const PLATE_RGB: Rgb = [200, 203, 208];
const OBJECT_RGB: Rgb = [86, 180, 233];
/// Colour of a crushed, dropped or tipped object.
const FAILED_RGB: Rgb = [204, 51, 51];
const PIXELS_MAX: u32 = 4096;

/// View of a scene from a fixed direction. The table has a grid of 100 mm.
#[derive(Clone, Debug)]
pub struct SceneView {
    links: Arc<Links>,
    robot: RobotModel,
    shapes: Vec<Shape>,
    plates: Vec<Body>,
    view: View,
    /// Middle of the picture, base frame, m.
    middle_m: Point3<f64>,
    /// Height of the picture, m.
    span_m: f64,
}

/// Size of a picture that is out of range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureSizeError {
    size_px: [u32; 2],
}

impl std::error::Error for PictureSizeError {}

impl std::fmt::Display for PictureSizeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [width, height] = self.size_px;
        write!(
            f,
            "could not draw: the size is {width} x {height} px, needs 1 to {PIXELS_MAX} px each; \
             choose another width and height"
        )
    }
}

impl SceneView {
    /// Makes a view of a hand and its scene.
    #[must_use]
    pub fn new(links: Arc<Links>, robot: &RobotModel, side: HandSide, scene: &Scene) -> Self {
        let (from_m, yaw_rad) = scene.grasp_hint(0).map_or_else(
            || (robot.hand(side).home_m().into(), 0.0),
            |hint| (hint.from_m, hint.yaw_rad),
        );
        let place_m = scene.place.map_or(from_m, |place| place.from_m);
        let middle = |axis: usize| f64::midpoint(from_m[axis], place_m[axis]);
        let apart_m = libm::hypot(place_m[0] - from_m[0], place_m[1] - from_m[1]);
        let shapes = scene.objects.iter().map(|placed| placed.object.shape);
        let plates = scene.plates.iter().flat_map(|plate| {
            let [x, y] = plate.centre_m;
            let at = Isometry3::translation(x, y, plate.height_m / 2.0);
            let [half_x, half_y] = plate.half_m;
            let size_m = [2.0 * half_x, 2.0 * half_y, plate.height_m];
            primitive(&at, Form::Box { size_m }, PLATE_RGB)
        });
        Self {
            links,
            robot: robot.clone(),
            shapes: shapes.collect(),
            plates: plates.collect(),
            view: View::from_direction(facing(yaw_rad), HEIGHT_RAD),
            middle_m: Point3::new(middle(0), middle(1), MIDDLE_M),
            span_m: SPAN_M + apart_m,
        }
    }

    /// Draws the robot at these joint positions (rad or m) and the objects of the ground truth.
    ///
    /// # Errors
    /// A side of the picture has no pixel, or more than 4096.
    pub fn draw(
        &self,
        q: &[f64],
        truth: &WorldTruth,
        size_px: [u32; 2],
    ) -> Result<Drawing, PictureSizeError> {
        if size_px.iter().any(|side| !(1..=PIXELS_MAX).contains(side)) {
            return Err(PictureSizeError { size_px });
        }
        let [width, height] = size_px.map(f64::from);
        let px_per_m = width.min(height) / self.span_m;
        let [x_m, y_m] = self.view.plane_m(&self.middle_m);
        let sheet = Sheet {
            px_per_m,
            corner_m: [x_m - width / px_per_m / 2.0, y_m + height / px_per_m / 2.0],
            corner_px: [0.0, 0.0],
        };
        let mut drawing = Drawing {
            size_px: [width, height],
            marks: Vec::new(),
        };
        self.draw_table(&mut drawing, &sheet);
        let mut bodies = self.links.bodies(q);
        bodies.extend(fingertips(&self.robot, q));
        bodies.extend(self.plates.iter().cloned());
        let truths = truth.objects.iter().take(truth.object_count as usize);
        for (truth, shape) in truths.zip(&self.shapes) {
            bodies.extend(object(truth, shape));
        }
        self.view.draw(&mut drawing, &sheet, &bodies);
        draw_closing_axes(&mut drawing, &self.view, &sheet, &self.robot, q);
        Ok(drawing)
    }

    fn draw_table(&self, drawing: &mut Drawing, sheet: &Sheet) {
        let [x, y] = [self.middle_m.x, self.middle_m.y].map(|at| (at / GRID_M).round() * GRID_M);
        let place =
            |dx: f64, dy: f64| sheet.place(self.view.plane_m(&Point3::new(x + dx, y + dy, 0.0)));
        let signs = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        drawing.marks.push(Mark::Area {
            corners: signs.map(|(a, b)| place(a * TABLE_M, b * TABLE_M)).to_vec(),
            fill: TABLE_RGB,
            edge: EDGE,
        });
        let count = (TABLE_M / GRID_M).round() as i32;
        for at in (-count..=count).map(|step| f64::from(step) * GRID_M) {
            drawing.add_line([place(at, -TABLE_M), place(at, TABLE_M)], 1.0, GRID_RGB);
            drawing.add_line([place(-TABLE_M, at), place(TABLE_M, at)], 1.0, GRID_RGB);
        }
    }
}

/// Returns the azimuth of the view for a closing axis: the axis lies across the picture, and the
/// viewer is on the side that is farther from the robot's base.
fn facing(closing_yaw_rad: f64) -> f64 {
    let candidates = [AZIMUTH_RAD, AZIMUTH_RAD + 2.0 * FRAC_PI_2];
    let azimuths = candidates.map(|offset| closing_yaw_rad + offset);
    let away = |azimuth: &f64| libm::cos(*azimuth);
    let [a, b] = azimuths;
    if away(&a) >= away(&b) { a } else { b }
}

fn object(truth: &ObjectTruth, shape: &Shape) -> Vec<Body> {
    let [w, i, j, k] = truth.orientation;
    let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k));
    let position_m = Vector3::from(truth.position_m);
    let at = Isometry3::from_parts(Translation3::from(position_m), rotation);
    let has_failed = truth.crushed | truth.dropped | truth.tipped != 0;
    let rgb = if has_failed { FAILED_RGB } else { OBJECT_RGB };
    let form = match *shape {
        Shape::Box { half_m } => Form::Box {
            size_m: (2.0 * half_m).into(),
        },
        Shape::Cylinder {
            radius_m,
            half_height_m,
        } => Form::Cylinder {
            radius_m,
            length_m: 2.0 * half_height_m,
        },
    };
    let mut faces = primitive(&at, form, rgb);
    for face in &mut faces {
        // The side of a cylinder is drawn like a face that the light reaches partly.
        if matches!(face.shade, Shade::Plain) {
            face.rgb = face.rgb.map(|part| (f64::from(part) * 0.85) as u8);
        }
    }
    faces
}

#[cfg(test)]
mod tests {
    use robot_model::TWO_HAND_ARM;
    use sim_backend::{Object, Sensed, World};

    use super::*;

    fn drawn(names: &[&str], size_px: [u32; 2]) -> Result<Drawing, PictureSizeError> {
        let robot = TWO_HAND_ARM.load().expect("built-in");
        let mut scene = Scene::default();
        for name in names {
            let object = Object::built_in(name).expect("built-in");
            scene = Scene::grasp(object, HandSide::Right);
        }
        let mut world = World::new(&robot, &scene, 1).expect("a world");
        let mut sensed = Sensed::default();
        world.sense(&mut sensed);
        let links = Arc::new(Links::load(&TWO_HAND_ARM).expect("built-in"));
        let view = SceneView::new(links, &robot, HandSide::Right, &scene);
        view.draw(&sensed.joints.position, &world.truth(), size_px)
    }

    #[test]
    fn object_and_fingertips_are_drawn_in_the_middle() {
        let (width, _, with) = drawn(&["wood"], [200, 160]).expect("a picture").pixels();
        let (_, _, without) = drawn(&[], [200, 160]).expect("a picture").pixels();
        // The proportions of the object's colour, whatever the shade. Blended edges of blue links
        // have them in a few places.
        let is_object = |pixel: &[u8]| {
            let [red, green, blue] = [pixel[0], pixel[1], pixel[2]].map(f64::from);
            let is_share = |part: f64, of_object: u8| {
                (part / blue - f64::from(of_object) / f64::from(OBJECT_RGB[2])).abs() < 0.05
            };
            blue > 120.0 && is_share(red, OBJECT_RGB[0]) && is_share(green, OBJECT_RGB[1])
        };
        let at: Vec<usize> = (0..with.len() / 3)
            .filter(|n| is_object(&with[3 * n..3 * n + 3]))
            .collect();
        assert!(at.len() > 200, "{} pixels of the object", at.len());
        let mean_x = at.iter().map(|n| n % width).sum::<usize>() / at.len();
        assert!((80..120).contains(&mean_x), "{mean_x}");
        let others = without.chunks_exact(3).filter(|pixel| is_object(pixel));
        assert!(others.count() < at.len() / 10, "no object");
        let is_green = |pixel: &[u8]| pixel[1] > 120 && pixel[0] < 60;
        assert!(with.chunks_exact(3).filter(|pixel| is_green(pixel)).count() > 50);
    }

    #[test]
    fn size_out_of_range_is_rejected_with_limit() {
        for size_px in [[0, 100], [100, 5000]] {
            let error = drawn(&["wood"], size_px).expect_err("too small or too large");
            let text = error.to_string();
            assert!(text.contains("1 to 4096") && text.contains("100"), "{text}");
        }
    }
}
