//! Every link of a URDF as viewers want it: which joint carries it, where it is for given joint angles, what it looks like.
//!
//! * **In:** the text of a URDF, the names of a robot's joints, joint angles. **Out:** the place of each link in its parent, and its visual shapes.
//! * **Invariants:** parents come before their children; joints are numbered as the robot's joint vectors have them, and one
//!   that mimics another follows it. A joint that is none of the robot's stands at zero.
//! * **Absent on purpose:** meshes, which would need files beside the URDF, and everything that the controller computes
//!   with: that is [`crate::RobotModel`].

use std::string::String;
use std::vec::Vec;
use std::{format, vec};

use nalgebra::{Translation3, Unit, UnitQuaternion, Vector3};
use urdf_rs::{Geometry, Joint, JointType, Link, Pose, Robot, Visual};

use crate::files::RobotFiles;
use crate::urdf::{Misfit, ModelError, misfit};

/// Colour of what the URDF gives none, red, green, blue, opaqueness, 0 to 1.
const PLAIN_RGBA: [f64; 4] = [0.6, 0.6, 0.6, 1.0];

impl RobotFiles {
    /// The links, for viewers.
    ///
    /// # Errors
    /// As [`RobotFiles::load`].
    pub fn skeleton(&self) -> Result<Skeleton, ModelError> {
        let robot = self.load()?;
        let names = robot.joints().map(|joint| joint.name.as_str().into());
        Skeleton::read(&self.urdf, names.collect())
    }
}

/// All links of a robot.
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
    /// Place of its parent in [`Skeleton::limbs`]; `None` for the root.
    pub parent: Option<usize>,
    /// Where the joint sits in the parent, at zero.
    pub origin: Placement,
    /// Axis of the joint in its own frame, unit length.
    pub axis: [f64; 3],
    /// Place in a joint vector of the value that moves it; `None` for a joint that nothing moves.
    pub joint: Option<usize>,
    /// Motion per motion of that value: 1, or the multiplier of a joint that mimics another.
    pub ratio: f64,
    /// Motion at value zero.
    pub offset: f64,
    /// Whether the joint slides along its axis instead of turning about it.
    pub slides: bool,
    /// What the link looks like.
    pub shapes: Vec<Shape>,
}

/// A place and a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// m.
    pub translation_m: [f64; 3],
    /// Unit quaternion x, y, z, w.
    pub rotation_xyzw: [f64; 4],
}

/// One visual shape of a link.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Where its middle is in the link.
    pub origin: Placement,
    /// What it is.
    pub form: Form,
    /// Red, green, blue, opaqueness, 0 to 1.
    pub rgba: [f64; 4],
}

/// A primitive, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// About z.
    Cylinder {
        /// Radius.
        radius_m: f64,
        /// Length along z.
        length_m: f64,
    },
    /// A ball.
    Sphere {
        /// Radius.
        radius_m: f64,
    },
    /// A block.
    Box {
        /// Full lengths along x, y, z.
        size_m: [f64; 3],
    },
}

impl Skeleton {
    /// Reads a URDF of any structure whose moving joints have these names in a joint vector.
    ///
    /// # Errors
    /// [`ModelError`] if the text is not a URDF, or its links are no tree.
    pub fn read(urdf: &str, joint_names: Vec<String>) -> Result<Self, ModelError> {
        let robot = urdf_rs::read_from_string(urdf)?;
        let mut limbs = Vec::with_capacity(robot.links.len());
        let mut open = roots(&robot);
        // Breadth first, so that parents come before their children. Every link is carried once, or it is no tree.
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
                "{} links of which {} hang together",
                robot.links.len(),
                limbs.len()
            );
            return Err(misfit("the robot", was, "a tree of links").into());
        }
        Ok(Self { limbs, joint_names })
    }

    /// The links, parents first.
    #[must_use]
    pub fn limbs(&self) -> &[Limb] {
        &self.limbs
    }

    /// Names of the moving joints, in the order of joint vectors.
    #[must_use]
    pub fn joint_names(&self) -> &[String] {
        &self.joint_names
    }
}

impl Limb {
    /// Where the link is in its parent. A joint without a value stands at zero.
    #[must_use]
    pub fn placed(&self, q_rad: &[f64]) -> Placement {
        let coordinate = self.joint.and_then(|joint| q_rad.get(joint)).copied();
        let Some(coordinate) = coordinate else {
            return self.origin;
        };
        let value = self.ratio * coordinate + self.offset;
        let axis = Unit::new_unchecked(Vector3::from(self.axis));
        let moved = if self.slides {
            Translation3::from(*axis * value).into()
        } else {
            nalgebra::Isometry3::from_parts(
                Translation3::identity(),
                UnitQuaternion::from_axis_angle(&axis, value),
            )
        };
        placement(&(isometry(&self.origin) * moved))
    }
}

type Isometry = nalgebra::Isometry3<f64>;
type Open<'a> = (&'a Link, Option<usize>, Option<&'a Joint>);

/// Links that no joint carries.
fn roots(robot: &Robot) -> Vec<Open<'_>> {
    let is_carried = |link: &&Link| !robot.joints.iter().any(|j| j.child.link == link.name);
    let roots = robot.links.iter().filter(is_carried);
    roots.map(|link| (link, None, None)).collect()
}

fn child<'a>(robot: &'a Robot, joint: &Joint) -> Result<&'a Link, Misfit> {
    let name = &joint.child.link;
    let found = robot.links.iter().find(|link| link.name == *name);
    found.ok_or_else(|| misfit(format!("link `{name}`"), "missing", "a link of this name"))
}

fn limb(
    robot: &Robot,
    link: &Link,
    parent: Option<usize>,
    joint: Option<&Joint>,
    names: &[String],
) -> Result<Limb, Misfit> {
    let mut limb = Limb {
        name: link.name.clone(),
        parent,
        origin: placement(&Isometry::identity()),
        axis: [0.0, 0.0, 1.0],
        joint: None,
        ratio: 1.0,
        offset: 0.0,
        slides: false,
        shapes: vec![],
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
    }
    Ok(limb)
}

fn axis(joint: &Joint) -> Result<[f64; 3], Misfit> {
    let axis = Vector3::from(joint.axis.xyz.0).try_normalize(1e-9);
    axis.filter(|axis| axis.iter().all(|x| x.is_finite()))
        .map(Into::into)
        .ok_or_else(|| {
            let was = format!("{:?}", joint.axis.xyz.0);
            misfit(
                format!("the axis of joint `{}`", joint.name),
                was,
                "a direction",
            )
        })
}

/// `None` for what cannot be drawn from the URDF alone.
fn shape(robot: &Robot, link: &Link, visual: &Visual) -> Result<Option<Shape>, Misfit> {
    let what = || format!("a visual of link `{}`", link.name);
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
        origin: pose(&visual.origin, what)?,
        form,
        rgba: colour(robot, visual),
    }))
}

/// The material's own colour, or that of the robot's material of its name.
fn colour(robot: &Robot, visual: &Visual) -> [f64; 4] {
    let own = visual.material.as_ref();
    let named = own.and_then(|own| robot.materials.iter().find(|m| m.name == own.name));
    let colours = [own, named].into_iter().flatten();
    let mut colours = colours.filter_map(|material| material.color.as_ref());
    colours.next().map_or(PLAIN_RGBA, |colour| colour.rgba.0)
}

fn pose(pose: &Pose, what: impl Fn() -> String) -> Result<Placement, Misfit> {
    let ([x, y, z], [roll, pitch, yaw]) = (pose.xyz.0, pose.rpy.0);
    if [x, y, z, roll, pitch, yaw].iter().any(|v| !v.is_finite()) {
        let was = format!("xyz {:?} rpy {:?}", pose.xyz.0, pose.rpy.0);
        return Err(misfit(what(), was, "finite numbers (m, rad)"));
    }
    let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    Ok(placement(&Isometry::from_parts(
        Translation3::new(x, y, z),
        rotation,
    )))
}

fn placement(isometry: &Isometry) -> Placement {
    Placement {
        translation_m: isometry.translation.vector.into(),
        rotation_xyzw: isometry.rotation.coords.into(),
    }
}

fn isometry(placement: &Placement) -> Isometry {
    let rotation = nalgebra::Quaternion::from_vector(placement.rotation_xyzw.into());
    Isometry::from_parts(
        Translation3::from(Vector3::from(placement.translation_m)),
        UnitQuaternion::new_unchecked(rotation),
    )
}
