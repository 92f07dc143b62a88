//! Bodies to draw: links of a robot and primitive shapes, split into convex faces.

use std::f64::consts::TAU;
use std::sync::OnceLock;

use atas_meshes::{Mesh, Meshes};
use nalgebra::{Isometry3, Point3, Vector3};
use robot_model::{Form, ModelError, RobotFiles, Skeleton};

use super::mark::{Rgb, rgb_of};

/// Half width of a link without shapes, m.
const LINK_HALF_WIDTH_M: f64 = 0.004;
const LINK_RGB: Rgb = [191, 191, 191];
/// Corners of the end of a cylinder.
const RIM_CORNERS: usize = 20;

/// Part of the picture: one corner is a ball, two a thick line, more the convex hull of the
/// corners.
#[derive(Clone, Debug)]
pub(super) struct Body {
    /// Corners, base frame, m.
    pub(super) corners: Vec<Point3<f64>>,
    /// Radius of a ball or of a line, m.
    pub(super) half_m: f64,
    pub(super) rgb: Rgb,
    pub(super) shade: Shade,
}

/// Brightness of a body.
#[derive(Clone, Copy, Debug)]
pub(super) enum Shade {
    /// Seen from every direction, without shading.
    Plain,
    /// Face with this outward normal, base frame.
    Face(Vector3<f64>),
    /// Triangle of a mesh with this outward normal, drawn without an edge.
    Facet(Vector3<f64>),
}

impl Shade {
    /// Returns the outward normal, if the body has one.
    pub(super) fn normal(&self) -> Option<Vector3<f64>> {
        match self {
            Self::Plain => None,
            Self::Face(normal) | Self::Facet(normal) => Some(*normal),
        }
    }
}

impl Body {
    pub(super) fn ball(centre_m: Vector3<f64>, radius_m: f64, rgb: Rgb) -> Self {
        Self {
            corners: vec![centre_m.into()],
            half_m: radius_m,
            rgb,
            shade: Shade::Plain,
        }
    }

    fn line(ends: [Point3<f64>; 2]) -> Self {
        Self {
            corners: ends.to_vec(),
            half_m: LINK_HALF_WIDTH_M,
            rgb: LINK_RGB,
            shade: Shade::Plain,
        }
    }

    /// Returns the mean distance towards the eye, m.
    pub(super) fn depth_m(&self, towards_eye: &Vector3<f64>) -> f64 {
        let along = self.corners.iter().map(|at| towards_eye.dot(&at.coords));
        let reach_m = if self.corners.len() == 1 {
            self.half_m
        } else {
            0.0
        };
        along.sum::<f64>() / self.corners.len().max(1) as f64 + reach_m
    }
}

/// Links of a robot with their shapes and meshes. The first drawing reads the files of the meshes.
#[derive(Clone, Debug)]
pub struct Links {
    files: RobotFiles,
    skeleton: Skeleton,
    meshes: OnceLock<Meshes>,
}

impl Links {
    /// Loads the links; one value serves all views of a robot.
    ///
    /// # Errors
    /// The URDF is not a tree of links, or a number in it is not finite.
    pub fn load(files: &RobotFiles) -> Result<Self, ModelError> {
        Ok(Self {
            files: files.clone(),
            skeleton: files.skeleton()?,
            meshes: OnceLock::new(),
        })
    }

    /// Returns the meshes, with one sentence for each that is not drawn.
    pub(super) fn meshes(&self) -> &Meshes {
        let load = || Meshes::load(&self.files, &self.skeleton);
        self.meshes.get_or_init(load)
    }

    /// Returns the bodies at these joint positions. A line stands for a link without shapes.
    pub(super) fn bodies(&self, q: &[f64]) -> Vec<Body> {
        let base_from = self.skeleton.base_from_limbs(q);
        let mut bodies = Vec::new();
        let limbs = self.skeleton.limbs().iter().zip(&base_from);
        for ((limb, here), meshes) in limbs.zip(&self.meshes().links) {
            if let Some(parent) = limb.parent
                && limb.shapes.is_empty()
                && meshes.is_empty()
            {
                let ends = [&base_from[parent], here];
                bodies.push(Body::line(ends.map(|at| at.translation.vector.into())));
            }
            for shape in &limb.shapes {
                let at = here * shape.origin.isometry();
                bodies.extend(primitive(&at, shape.form, rgb_of(shape.rgba)));
            }
            bodies.extend(meshes.iter().flat_map(|mesh| faces(here, mesh)));
        }
        bodies
    }
}

/// Returns the triangles of a mesh.
fn faces(base_from_link: &Isometry3<f64>, mesh: &Mesh) -> Vec<Body> {
    let placed = mesh
        .points_m
        .iter()
        .map(|point| base_from_link * Point3::from(*point));
    let points_m: Vec<_> = placed.collect();
    let face = |corners: &[usize; 3]| {
        let [a, b, c] = corners.map(|corner| points_m[corner]);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
        Some(Body {
            corners: vec![a, b, c],
            half_m: 0.0,
            rgb: rgb_of(mesh.rgba),
            shade: Shade::Facet(normal),
        })
    };
    mesh.triangles.iter().filter_map(face).collect()
}

/// Returns the faces of a primitive.
pub(super) fn primitive(base_from_shape: &Isometry3<f64>, form: Form, rgb: Rgb) -> Vec<Body> {
    match form {
        Form::Sphere { radius_m } => {
            let centre_m = base_from_shape.translation.vector;
            vec![Body::ball(centre_m, radius_m, rgb)]
        }
        Form::Cylinder { radius_m, length_m } => {
            cylinder(base_from_shape, radius_m, length_m / 2.0, rgb)
        }
        Form::Box { size_m } => block(base_from_shape, Vector3::from(size_m) / 2.0, rgb),
    }
}

fn block(base_from_block: &Isometry3<f64>, half_m: Vector3<f64>, rgb: Rgb) -> Vec<Body> {
    let faces = (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]);
    let face = |(axis, sign): (usize, f64)| {
        let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
        let corner = |[a, b]: [f64; 2]| {
            let mut at = Vector3::zeros();
            (at[axis], at[second], at[third]) = (sign, a, b);
            base_from_block * Point3::from(at.component_mul(&half_m))
        };
        let mut normal = Vector3::zeros();
        normal[axis] = sign;
        Body {
            corners: [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                .map(corner)
                .to_vec(),
            half_m: 0.0,
            rgb,
            shade: Shade::Face(base_from_block * normal),
        }
    };
    faces.map(face).collect()
}

/// Returns the side of a cylinder about z, and both ends.
fn cylinder(base_from: &Isometry3<f64>, radius_m: f64, half_m: f64, rgb: Rgb) -> Vec<Body> {
    let rim = |z_m: f64| {
        (0..RIM_CORNERS).map(move |corner| {
            let (sin, cos) = libm::sincos(TAU * corner as f64 / RIM_CORNERS as f64);
            base_from * Point3::new(radius_m * cos, radius_m * sin, z_m)
        })
    };
    let body = |corners: Vec<Point3<f64>>, shade| Body {
        corners,
        half_m: 0.0,
        rgb,
        shade,
    };
    let side = rim(-half_m).chain(rim(half_m)).collect();
    let end = |sign: f64| {
        let normal = base_from * Vector3::new(0.0, 0.0, sign);
        body(rim(sign * half_m).collect(), Shade::Face(normal))
    };
    vec![body(side, Shade::Plain), end(1.0), end(-1.0)]
}
