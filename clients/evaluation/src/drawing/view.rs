//! Parallel projection of bodies onto a plane, sorted by depth.

use nalgebra::{Point3, Vector3};

use super::bodies::{Body, Shade};
use super::mark::{Drawing, EDGE, Mark, Rgb};

/// Direction of the light, base frame; the length does not matter.
const LIGHT: [f64; 3] = [0.4, -0.5, 0.9];
/// Brightness of a face that is turned away from the light.
const AMBIENT: f64 = 0.62;

/// Directions of the picture in the base frame, unit length and normal to each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub(super) right: Vector3<f64>,
    pub(super) up: Vector3<f64>,
}

/// Scale of a picture, and the place of its upper left corner on the plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheet {
    pub(super) px_per_m: f64,
    /// Left and upper edge on the plane, m.
    pub(super) corner_m: [f64; 2],
    /// Place of that corner, px.
    pub(super) corner_px: [f64; 2],
}

impl View {
    /// Returns the view from a direction: azimuth from +x towards +y, height above the horizon.
    pub(super) fn from_direction(azimuth_rad: f64, height_rad: f64) -> Self {
        let ((sa, ca), (sh, ch)) = (libm::sincos(azimuth_rad), libm::sincos(height_rad));
        let towards_eye = Vector3::new(ca * ch, sa * ch, sh);
        let right = Vector3::new(-sa, ca, 0.0);
        Self {
            right,
            up: towards_eye.cross(&right),
        }
    }

    fn towards_eye(&self) -> Vector3<f64> {
        self.right.cross(&self.up)
    }

    /// Returns a point on the plane, m.
    pub(super) fn plane_m(&self, point: &Point3<f64>) -> [f64; 2] {
        [self.right.dot(&point.coords), self.up.dot(&point.coords)]
    }

    /// Returns lowest and highest coordinates of the bodies on the plane, m.
    pub(super) fn bounds_m(&self, bodies: &[Body]) -> [[f64; 2]; 2] {
        let start = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        bodies.iter().fold(start, |[low, high], body| {
            let half_m = body.half_m;
            let points = body.corners.iter().map(|corner| self.plane_m(corner));
            points.fold([low, high], |[low, high], [x, y]| {
                [
                    [low[0].min(x - half_m), low[1].min(y - half_m)],
                    [high[0].max(x + half_m), high[1].max(y + half_m)],
                ]
            })
        })
    }

    /// Draws bodies from far to near. Faces turned away from the eye are hidden.
    pub(super) fn draw(&self, drawing: &mut Drawing, sheet: &Sheet, bodies: &[Body]) {
        let eye = self.towards_eye();
        let is_seen = |body: &&Body| {
            let normal = body.shade.normal();
            normal.is_none_or(|normal| normal.dot(&eye) > 1e-9)
        };
        let mut seen: Vec<&Body> = bodies.iter().filter(is_seen).collect();
        seen.sort_by(|a, b| a.depth_m(&eye).total_cmp(&b.depth_m(&eye)));
        let marks = seen.into_iter().map(|body| self.mark(sheet, body));
        drawing.marks.extend(marks);
    }

    fn mark(&self, sheet: &Sheet, body: &Body) -> Mark {
        let fill = lit(body);
        let points: Vec<[f64; 2]> = body
            .corners
            .iter()
            .map(|corner| sheet.place(self.plane_m(corner)))
            .collect();
        let radius = body.half_m * sheet.px_per_m;
        match points[..] {
            [centre] => Mark::Disc {
                centre,
                radius,
                fill,
            },
            [a, b] => Mark::Line {
                ends: [a, b],
                width: 2.0 * radius,
                colour: fill,
                is_dashed: false,
            },
            _ => Mark::Area {
                corners: hull(&points),
                fill,
                edge: match body.shade {
                    Shade::Facet(_) => fill,
                    Shade::Plain | Shade::Face(_) => EDGE,
                },
            },
        }
    }
}

impl Sheet {
    /// Converts a point of the plane to pixels.
    pub(super) fn place(&self, [x_m, y_m]: [f64; 2]) -> [f64; 2] {
        [
            (x_m - self.corner_m[0]) * self.px_per_m + self.corner_px[0],
            (self.corner_m[1] - y_m) * self.px_per_m + self.corner_px[1],
        ]
    }
}

fn lit(body: &Body) -> Rgb {
    let Some(normal) = body.shade.normal() else {
        return body.rgb;
    };
    let facing = normal.dot(&Vector3::from(LIGHT).normalize()).max(0.0);
    let brightness = AMBIENT + (1.0 - AMBIENT) * facing;
    body.rgb
        .map(|part| (f64::from(part) * brightness).round() as u8)
}

/// Returns the convex hull of points (A. M. Andrew, 1979).
pub(super) fn hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
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
