//! Skeleton of a robot for viewers: all links of a URDF, their joints, places and shapes.
//!
//! * **Inputs:** text of a URDF, joint names, joint positions. **Outputs:** the place of each link
//!   in its parent, and its visual shapes.
//! * **Invariants:** parents precede their children. Joint numbers equal those of joint vectors; a
//!   mimicking joint follows its master. Other joints stay at zero.
//! * **Not included:** the content of meshes, which needs files besides the URDF, and data of the
//!   controller ([`crate::RobotModel`]).

use std::string::String;
use std::vec::Vec;
use std::{format, vec};

use nalgebra::{Isometry3, Quaternion, Translation3, Unit, UnitQuaternion, Vector3};
use urdf_rs::{Geometry, Joint, JointType, Link, Pose, Robot, Visual};

use crate::files::RobotFiles;
use crate::urdf::{ModelError, ModelProblem, problem};

/// Default colour: red, green, blue, opacity, 0 to 1.
const PLAIN_RGBA: [f64; 4] = [0.6, 0.6, 0.6, 1.0];

impl RobotFiles {
    /// Loads the skeleton.
    pub fn skeleton(&self) -> Result<Skeleton, ModelError> {
        let robot = self.load()?;
        let names = robot.joints().map(|joint| joint.name.as_str().into());
        Skeleton::read(&self.urdf, names.collect())
    }
}

/// All links of a robot.
///
/// ```
/// use robot_model::TWO_HAND_ARM;
///
/// let skeleton = TWO_HAND_ARM.skeleton()?;
/// assert_eq!(skeleton.joint_names().len(), 22);
/// assert!(skeleton.limbs()[0].parent.is_none(), "the root comes first");
/// # Ok::<(), robot_model::ModelError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Skeleton {
    limbs: Vec<Limb>,
    joint_names: Vec<String>,
}

/// One link and the joint that carries it.
#[derive(Clone, Debug)]
pub struct Limb {
    /// Name of the link.
    pub name: String,
    /// Index of its parent in [`Skeleton::limbs`]; `None` for the root.
    pub parent: Option<usize>,
    /// Pose of the joint in the parent at zero.
    pub origin: Placement,
    /// Joint axis in the joint's frame, unit length.
    pub axis: [f64; 3],
    /// Index of the moving value in a joint vector; `None` for a joint without value.
    pub joint: Option<usize>,
    /// Motion per motion of that value: 1, or the multiplier of a mimicking joint.
    pub ratio: f64,
    /// Motion at value zero.
    pub offset: f64,
    /// True if the joint slides along its axis instead of turning about it.
    pub slides: bool,
    /// Visual shapes.
    pub shapes: Vec<Shape>,
    /// Visual meshes, which are files besides the URDF.
    pub meshes: Vec<MeshFile>,
}

/// Position and orientation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Position, m.
    pub translation_m: [f64; 3],
    /// Unit quaternion x, y, z, w.
    pub rotation_xyzw: [f64; 4],
}

/// One visual shape of a link.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Pose of its centre in the link.
    pub origin: Placement,
    /// Geometry.
    pub form: Form,
    /// Red, green, blue, opacity, 0 to 1.
    pub rgba: [f64; 4],
}

/// Visual mesh of a link: a file that the URDF names.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFile {
    /// Name in the URDF: a path, or `package://NAME/PATH`.
    pub name: String,
    /// Scale along each axis of the mesh.
    pub scale: [f64; 3],
    /// Pose of the mesh in the link.
    pub origin: Placement,
    /// Red, green, blue, opacity, 0 to 1.
    pub rgba: [f64; 4],
}

/// Geometric primitive, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// Cylinder about z.
    Cylinder {
        /// Radius.
        radius_m: f64,
        /// Length along z.
        length_m: f64,
    },
    /// Sphere.
    Sphere {
        /// Radius.
        radius_m: f64,
    },
    /// Block.
    Box {
        /// Full lengths along x, y, z.
        size_m: [f64; 3],
    },
}

impl Skeleton {
    /// Reads a URDF of any structure; the moving joints have these names in joint vectors.
    pub fn read(urdf: &str, joint_names: Vec<String>) -> Result<Self, ModelError> {
        let robot = urdf_rs::read_from_string(urdf)?;
        let mut limbs = Vec::with_capacity(robot.links.len());
        let mut open = roots(&robot);
        // Breadth first, so that parents precede children. In a tree each link has one carrier.
        while let Some((link, parent, joint)) = open.pop() {
            let index = limbs.len();
            if index >= robot.links.len() {
                open.push((link, parent, joint));
                break;
            }
            limbs.push(limb(&robot, link, parent, joint, &joint_names)?);
            let carried = robot.joints.iter().filter(|j| j.parent.link == link.name);
            for joint in carried {
                open.insert(0, (child(&robot, joint)?, Some(index), Some(joint)));
            }
        }
        if limbs.len() != robot.links.len() || !open.is_empty() {
            let was = format!(
                "{} links, of which {} are connected",
                robot.links.len(),
                limbs.len()
            );
            return Err(problem("the robot", was, "a tree of links").into());
        }
        Ok(Self { limbs, joint_names })
    }

    /// Returns the links, parents first.
    #[must_use]
    pub fn limbs(&self) -> &[Limb] {
        &self.limbs
    }

    /// Returns the pose of each link in the base frame, in the order of [`Skeleton::limbs`].
    #[must_use]
    pub fn base_from_limbs(&self, q: &[f64]) -> Vec<Isometry3<f64>> {
        let mut base_from: Vec<Isometry3<f64>> = Vec::with_capacity(self.limbs.len());
        for limb in &self.limbs {
            let own = limb.placed(q).isometry();
            base_from.push(limb.parent.map_or(own, |parent| base_from[parent] * own));
        }
        base_from
    }

    /// Returns the names of the moving joints, in the order of joint vectors.
    #[must_use]
    pub fn joint_names(&self) -> &[String] {
        &self.joint_names
    }
}

impl Placement {
    /// Returns the same pose as an isometry.
    #[must_use]
    pub fn isometry(&self) -> Isometry3<f64> {
        let rotation = Quaternion::from_vector(self.rotation_xyzw.into());
        Isometry3::from_parts(
            Translation3::from(Vector3::from(self.translation_m)),
            UnitQuaternion::new_unchecked(rotation),
        )
    }
}

impl Limb {
    /// Returns the pose of the link in its parent. A joint without a value is at zero.
    #[must_use]
    pub fn placed(&self, q: &[f64]) -> Placement {
        let coordinate = self.joint.and_then(|joint| q.get(joint)).copied();
        let Some(coordinate) = coordinate else {
            return self.origin;
        };
        let value = self.ratio * coordinate + self.offset;
        let axis = Unit::new_unchecked(Vector3::from(self.axis));
        let moved = if self.slides {
            Translation3::from(*axis * value).into()
        } else {
            Isometry3::from_parts(
                Translation3::identity(),
                UnitQuaternion::from_axis_angle(&axis, value),
            )
        };
        placement(&(self.origin.isometry() * moved))
    }
}

type Open<'a> = (&'a Link, Option<usize>, Option<&'a Joint>);

/// Returns the links that no joint carries.
fn roots(robot: &Robot) -> Vec<Open<'_>> {
    let is_carried = |link: &&Link| !robot.joints.iter().any(|j| j.child.link == link.name);
    let roots = robot.links.iter().filter(is_carried);
    roots.map(|link| (link, None, None)).collect()
}

fn child<'a>(robot: &'a Robot, joint: &Joint) -> Result<&'a Link, ModelProblem> {
    let name = &joint.child.link;
    let found = robot.links.iter().find(|link| link.name == *name);
    found.ok_or_else(|| problem(format!("link `{name}`"), "missing", "a link of this name"))
}

fn limb(
    robot: &Robot,
    link: &Link,
    parent: Option<usize>,
    joint: Option<&Joint>,
    names: &[String],
) -> Result<Limb, ModelProblem> {
    let mut limb = Limb {
        name: link.name.clone(),
        parent,
        origin: placement(&Isometry3::identity()),
        axis: [0.0, 0.0, 1.0],
        joint: None,
        ratio: 1.0,
        offset: 0.0,
        slides: false,
        shapes: vec![],
        meshes: vec![],
    };
    if let Some(joint) = joint {
        limb.origin = pose(&joint.origin, || {
            format!("the origin of joint `{}`", joint.name)
        })?;
        let driver = joint
            .mimic
            .as_ref()
            .map_or(&joint.name, |mimic| &mimic.joint);
        limb.joint = names.iter().position(|name| name == driver);
        if let Some(mimic) = &joint.mimic {
            limb.ratio = mimic.multiplier.unwrap_or(1.0);
            limb.offset = mimic.offset.unwrap_or(0.0);
        }
        limb.slides = joint.joint_type == JointType::Prismatic;
        if limb.joint.is_some() {
            limb.axis = axis(joint)?;
        }
    }
    for visual in &link.visual {
        limb.shapes.extend(shape(robot, link, visual)?);
        limb.meshes.extend(mesh_file(robot, link, visual)?);
    }
    Ok(limb)
}

fn axis(joint: &Joint) -> Result<[f64; 3], ModelProblem> {
    let axis = Vector3::from(joint.axis.xyz.0).try_normalize(1e-9);
    axis.filter(|axis| axis.iter().all(|x| x.is_finite()))
        .map(Into::into)
        .ok_or_else(|| {
            let was = format!("{:?}", joint.axis.xyz.0);
            problem(
                format!("the axis of joint `{}`", joint.name),
                was,
                "a direction",
            )
        })
}

/// Returns the mesh of a visual; `None` for a primitive.
fn mesh_file(
    robot: &Robot,
    link: &Link,
    visual: &Visual,
) -> Result<Option<MeshFile>, ModelProblem> {
    let Geometry::Mesh { filename, scale } = &visual.geometry else {
        return Ok(None);
    };
    let scale = scale.as_ref().map_or([1.0; 3], |scale| scale.0);
    if scale.iter().any(|factor| !factor.is_finite()) {
        let was = format!("{scale:?}");
        return Err(problem(
            visual_name(link),
            was,
            "a finite scale of its mesh",
        ));
    }
    Ok(Some(MeshFile {
        name: filename.clone(),
        scale,
        origin: pose(&visual.origin, || visual_name(link))?,
        rgba: colour(robot, visual),
    }))
}

fn visual_name(link: &Link) -> String {
    format!("a visual of link `{}`", link.name)
}

/// Returns `None` if the URDF alone does not describe the shape.
fn shape(robot: &Robot, link: &Link, visual: &Visual) -> Result<Option<Shape>, ModelProblem> {
    let form = match &visual.geometry {
        Geometry::Cylinder { radius, length } | Geometry::Capsule { radius, length } => {
            Form::Cylinder {
                radius_m: *radius,
                length_m: *length,
            }
        }
        Geometry::Sphere { radius } => Form::Sphere { radius_m: *radius },
        Geometry::Box { size } => Form::Box { size_m: size.0 },
        Geometry::Mesh { .. } => return Ok(None),
    };
    Ok(Some(Shape {
        origin: pose(&visual.origin, || visual_name(link))?,
        form,
        rgba: colour(robot, visual),
    }))
}

/// Returns the colour of the material, or of the robot's material of the same name.
fn colour(robot: &Robot, visual: &Visual) -> [f64; 4] {
    let own = visual.material.as_ref();
    let named = own.and_then(|own| robot.materials.iter().find(|m| m.name == own.name));
    let colours = [own, named].into_iter().flatten();
    let mut colours = colours.filter_map(|material| material.color.as_ref());
    colours.next().map_or(PLAIN_RGBA, |colour| colour.rgba.0)
}

fn pose(pose: &Pose, what: impl Fn() -> String) -> Result<Placement, ModelProblem> {
    let ([x, y, z], [roll, pitch, yaw]) = (pose.xyz.0, pose.rpy.0);
    if [x, y, z, roll, pitch, yaw].iter().any(|v| !v.is_finite()) {
        let was = format!("xyz {:?} rpy {:?}", pose.xyz.0, pose.rpy.0);
        return Err(problem(what(), was, "finite numbers (m, rad)"));
    }
    let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    Ok(placement(&Isometry3::from_parts(
        Translation3::new(x, y, z),
        rotation,
    )))
}

fn placement(isometry: &Isometry3<f64>) -> Placement {
    Placement {
        translation_m: isometry.translation.vector.into(),
        rotation_xyzw: isometry.rotation.coords.into(),
    }
}
