//! Shapes of objects and their contact faces.
//!
//! A convex shape meets a dome on the [`Face`] with the largest separation from the dome's centre.
//! The face's supporting plane bounds the shape: one dot product per bristle excludes bristles that
//! cannot touch; only the others need [`Face::under`]. Coordinates are the object's: origin in the
//! middle, z upright.

use nalgebra::Vector3;

use crate::lanes::{Lanes, Vectors};

/// Outline of a rigid object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Box.
    Box {
        /// Half edges along x, y, z, m.
        half_m: Vector3<f64>,
    },
    /// Cylinder about z.
    Cylinder {
        /// Radius, m.
        radius_m: f64,
        /// Half height, m.
        half_height_m: f64,
    },
}

/// Face of a shape, for one fingertip.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    extent: Extent,
    /// Outward normal of the supporting plane.
    pub(crate) normal: Vector3<f64>,
    /// Distance of the supporting plane from the origin, m.
    pub(crate) offset_m: f64,
}

#[derive(Clone, Copy, Debug)]
enum Extent {
    /// Flat face within these half edges, m; infinite along its own normal.
    Rectangle(Vector3<f64>),
    /// End of a cylinder with this radius, m.
    Disc(f64),
    /// Side of a cylinder with this radius and half height, m.
    Side(f64, f64),
}

impl Shape {
    /// Returns the face with the largest separation from a point.
    pub(crate) fn face_towards(&self, point_m: &Vector3<f64>) -> Face {
        match *self {
            Self::Box { half_m } => {
                let axis = (point_m.abs() - half_m).imax();
                let mut edges_m = half_m;
                edges_m[axis] = f64::INFINITY;
                Face::flat(
                    axis,
                    point_m[axis],
                    half_m[axis],
                    Extent::Rectangle(edges_m),
                )
            }
            Self::Cylinder {
                radius_m,
                half_height_m,
            } => {
                let radial_m = radial_distance_m(point_m);
                if point_m.z.abs() - half_height_m > radial_m - radius_m {
                    return Face::flat(2, point_m.z, half_height_m, Extent::Disc(radius_m));
                }
                // On the axis any direction is valid.
                let normal = if radial_m > 0.0 {
                    Vector3::new(point_m.x, point_m.y, 0.0) / radial_m
                } else {
                    Vector3::x()
                };
                Face {
                    extent: Extent::Side(radius_m, half_height_m),
                    normal,
                    offset_m: radius_m,
                }
            }
        }
    }

    pub(crate) fn bounding_radius_m(&self) -> f64 {
        match *self {
            Self::Box { half_m } => half_m.norm(),
            Self::Cylinder {
                radius_m,
                half_height_m,
            } => (radius_m * radius_m + half_height_m * half_height_m).sqrt(),
        }
    }

    /// Returns half of the height of the upright shape, m.
    #[must_use]
    pub fn half_height_m(&self) -> f64 {
        match *self {
            Self::Box { half_m } => half_m.z,
            Self::Cylinder { half_height_m, .. } => half_height_m,
        }
    }

    /// Returns the extent along x, m: the width for closing axis x.
    #[must_use]
    pub fn width_m(&self) -> f64 {
        match *self {
            Self::Box { half_m } => 2.0 * half_m.x,
            Self::Cylinder { radius_m, .. } => 2.0 * radius_m,
        }
    }

    /// Returns the principal moments of inertia of a homogeneous body of this mass, kg·m².
    pub(crate) fn inertia_kg_m2(&self, mass_kg: f64) -> Vector3<f64> {
        match *self {
            Self::Box { half_m } => {
                let square = half_m.component_mul(&half_m);
                Vector3::new(
                    square.y + square.z,
                    square.x + square.z,
                    square.x + square.y,
                ) * (mass_kg / 3.0)
            }
            Self::Cylinder {
                radius_m,
                half_height_m,
            } => {
                let about_z = 0.5 * mass_kg * radius_m * radius_m;
                let about_x = 0.5 * about_z + mass_kg * half_height_m * half_height_m / 3.0;
                Vector3::new(about_x, about_x, about_z)
            }
        }
    }

    /// Returns possible table contacts: corners of a box, an octagon on each end of a cylinder.
    pub(crate) fn corners_m(&self) -> Vec<Vector3<f64>> {
        match *self {
            Self::Box { half_m } => {
                let sign =
                    |corner: usize, axis: usize| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
                let corner =
                    |index| half_m.component_mul(&Vector3::from_fn(|axis, _| sign(index, axis)));
                (0..8).map(corner).collect()
            }
            Self::Cylinder {
                radius_m,
                half_height_m,
            } => {
                let corner = |eighth: u32, z_m: f64| {
                    let (sin, cos) = libm::sincos(f64::from(eighth) * core::f64::consts::FRAC_PI_4);
                    Vector3::new(radius_m * cos, radius_m * sin, z_m)
                };
                let ends = [-half_height_m, half_height_m];
                ends.into_iter()
                    .flat_map(|z_m| (0..8).map(move |eighth| corner(eighth, z_m)))
                    .collect()
            }
        }
    }
}

impl Face {
    /// Returns the face normal to an axis, on the side of the coordinate's sign.
    fn flat(axis: usize, side: f64, offset_m: f64, extent: Extent) -> Self {
        let mut normal = Vector3::zeros();
        normal[axis] = 1.0_f64.copysign(side);
        Self {
            extent,
            normal,
            offset_m,
        }
    }

    /// Returns depths below the face, m, and outward normals. Depth is negative above the face and
    /// −∞ outside its edges.
    #[inline(always)]
    pub(crate) fn under<L: Lanes>(&self, cpu: L::Cpu, point_m: Vectors<L>) -> (L, Vectors<L>) {
        let number = |value| L::splat(cpu, value);
        let radial_m = || (point_m.x * point_m.x + point_m.y * point_m.y).sqrt();
        let (inside, depth_m, normal) = match self.extent {
            Extent::Rectangle(edges_m) => {
                let inside = point_m.x.abs().at_most(number(edges_m.x))
                    & point_m.y.abs().at_most(number(edges_m.y))
                    & point_m.z.abs().at_most(number(edges_m.z));
                let normal = Vectors::splat(cpu, &self.normal);
                (inside, number(self.offset_m) - normal.dot(point_m), normal)
            }
            Extent::Disc(radius_m) => {
                let inside = radial_m().at_most(number(radius_m));
                let normal = Vectors::splat(cpu, &self.normal);
                (inside, number(self.offset_m) - normal.dot(point_m), normal)
            }
            Extent::Side(radius_m, half_height_m) => {
                let (radial_m, none_m) = (radial_m(), number(0.0));
                let inside =
                    point_m.z.abs().at_most(number(half_height_m)) & radial_m.above(none_m);
                let normal = Vectors {
                    x: point_m.x / radial_m,
                    y: point_m.y / radial_m,
                    z: none_m,
                };
                (inside, number(radius_m) - radial_m, normal)
            }
        };
        let beside_m = number(f64::NEG_INFINITY);
        (L::select(inside, depth_m, beside_m), normal)
    }
}

fn radial_distance_m(point_m: &Vector3<f64>) -> f64 {
    (point_m.x * point_m.x + point_m.y * point_m.y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::portable::Numbers;
    use crate::lanes::vector;

    const BOX: Shape = Shape::Box {
        half_m: Vector3::new(0.02, 0.03, 0.04),
    };
    const CYLINDER: Shape = Shape::Cylinder {
        radius_m: 0.03,
        half_height_m: 0.06,
    };

    fn depth_at(face: &Face, point_m: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        let (depth_m, normal) = face.under((), Vectors::<Numbers>::splat((), point_m));
        let depth_m = depth_m.store()[0];
        depth_m
            .is_finite()
            .then(|| (depth_m, vector(&normal.store(), 0)))
    }

    #[test]
    fn faces_give_depth_and_normal() {
        let check =
            |shape: Shape, from: [f64; 3], at: [f64; 3], expected: Option<(f64, [f64; 3])>| {
                let face = shape.face_towards(&Vector3::from(from));
                let depth = depth_at(&face, &Vector3::from(at));
                match (depth, expected) {
                    (Some((depth_m, normal)), Some((expected_m, expected))) => {
                        assert!(
                            (depth_m - expected_m).abs() < 1e-12,
                            "{from:?} {at:?}: {depth_m}"
                        );
                        assert!(
                            (normal - Vector3::from(expected)).norm() < 1e-12,
                            "{from:?} {at:?}: {normal}"
                        );
                    }
                    (None, None) => {}
                    _ => panic!("{from:?} {at:?}: {depth:?}, expected {expected:?}"),
                }
            };
        check(
            BOX,
            [0.05, 0.0, 0.0],
            [0.019, 0.0, 0.0],
            Some((0.001, [1.0, 0.0, 0.0])),
        );
        check(
            BOX,
            [-0.05, 0.0, 0.0],
            [-0.022, 0.0, 0.0],
            Some((-0.002, [-1.0, 0.0, 0.0])),
        );
        check(
            BOX,
            [0.0, -0.05, 0.03],
            [0.0, -0.029, 0.03],
            Some((0.001, [0.0, -1.0, 0.0])),
        );
        check(
            BOX,
            [0.0, 0.0, 0.05],
            [0.0, 0.0, 0.039],
            Some((0.001, [0.0, 0.0, 1.0])),
        );
        check(BOX, [0.05, 0.0, 0.0], [0.019, 0.031, 0.0], None);
        check(
            CYLINDER,
            [0.05, 0.0, 0.0],
            [0.029, 0.0, 0.05],
            Some((0.001, [1.0, 0.0, 0.0])),
        );
        check(
            CYLINDER,
            [0.05, 0.0, 0.0],
            [0.0, -0.029, 0.0],
            Some((0.001, [0.0, -1.0, 0.0])),
        );
        check(CYLINDER, [0.05, 0.0, 0.0], [0.029, 0.0, 0.061], None);
        check(
            CYLINDER,
            [0.0, 0.01, 0.08],
            [0.0, 0.02, 0.059],
            Some((0.001, [0.0, 0.0, 1.0])),
        );
        check(CYLINDER, [0.0, 0.01, -0.08], [0.0, 0.031, -0.059], None);
    }

    /// The supporting plane never underestimates a depth: no touching bristle is missed.
    #[test]
    fn supporting_planes_bound_the_shape() {
        let mut random = crate::random::Random::new(1, 0);
        let mut point = || Vector3::from_fn(|_, _| random.between(-0.08, 0.08));
        for _ in 0..20_000 {
            let (from_m, at_m) = (point(), point());
            for shape in [BOX, CYLINDER] {
                let face = shape.face_towards(&from_m);
                if let Some((depth_m, _)) = depth_at(&face, &at_m) {
                    let plane_m = face.offset_m - face.normal.dot(&at_m);
                    assert!(depth_m <= plane_m + 1e-12, "{shape:?} {from_m} {at_m}");
                }
            }
        }
    }

    #[test]
    fn corners_lie_on_the_bounding_sphere() {
        for shape in [BOX, CYLINDER] {
            for (index, corner_m) in shape.corners_m().iter().enumerate() {
                assert!((corner_m.norm() - shape.bounding_radius_m()).abs() < 1e-12);
                assert!(
                    (corner_m.z.abs() - shape.half_height_m()).abs() < 1e-12,
                    "corner {index}"
                );
            }
        }
    }

    #[test]
    fn inertia_of_a_cube_and_of_a_disc() {
        let cube = Shape::Box {
            half_m: Vector3::repeat(0.05),
        }
        .inertia_kg_m2(0.6);
        assert!(
            (cube - Vector3::repeat(0.6 * 0.01 / 6.0)).norm() < 1e-12,
            "{cube}"
        );
        let disc = Shape::Cylinder {
            radius_m: 0.1,
            half_height_m: 0.0,
        }
        .inertia_kg_m2(2.0);
        assert!(
            (disc - Vector3::new(0.005, 0.005, 0.01)).norm() < 1e-12,
            "{disc}"
        );
    }
}
