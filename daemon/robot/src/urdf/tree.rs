//! Walking a URDF: which joint carries a link, and the rigid transform along fixed joints.

use std::format;
use std::string::String;

use nalgebra::{Matrix3, Vector3};
use urdf_rs::{Joint, JointType, Link, Pose, Robot};

use super::error::{ModelError, misfit};
use crate::transform::Transform;

/// A URDF in which every link is carried by at most one joint.
pub(super) struct Tree<'a> {
    robot: &'a Robot,
}

impl<'a> Tree<'a> {
    pub(super) fn new(robot: &'a Robot) -> Result<Tree<'a>, ModelError> {
        for (index, joint) in robot.joints.iter().enumerate() {
            let child = &joint.child.link;
            if let Some(other) = robot.joints[..index]
                .iter()
                .find(|other| other.child.link == *child)
            {
                let was = format!("the child of joints `{}` and `{}`", other.name, joint.name);
                return Err(misfit(
                    format!("link `{child}`"),
                    was,
                    "one joint that carries it",
                ));
            }
        }
        Ok(Tree { robot })
    }

    pub(super) fn robot(&self) -> &'a Robot {
        self.robot
    }

    pub(super) fn joint(&self, name: &str) -> Result<&'a Joint, ModelError> {
        let found = self.robot.joints.iter().find(|joint| joint.name == name);
        found.ok_or_else(|| misfit(format!("joint `{name}`"), "missing", "a joint of this name"))
    }

    pub(super) fn link(&self, name: &str) -> Result<&'a Link, ModelError> {
        let found = self.robot.links.iter().find(|link| link.name == name);
        found.ok_or_else(|| misfit(format!("link `{name}`"), "missing", "a link of this name"))
    }

    /// Transform from link `from` (the root of the robot if `None`) to link `to` along fixed joints only.
    pub(super) fn fixed_path(&self, from: Option<&str>, to: &str) -> Result<Transform, ModelError> {
        let (top, mover, path) = self.climb(to)?;
        let expected = from.unwrap_or("the root link");
        match mover {
            Some(joint) if Some(&*joint.child.link) == from => Ok(path),
            None if from.is_none() => Ok(path),
            Some(joint) => Err(misfit(
                format!("link `{to}`"),
                format!("moved by joint `{}`", joint.name),
                format!("fixed to `{expected}`"),
            )),
            None => Err(misfit(
                format!("link `{to}`"),
                format!("fixed to `{top}`"),
                format!("fixed to `{expected}`"),
            )),
        }
    }

    /// The joint that moves a link, with the fixed transform from that joint's child link; `None` for the robot's base.
    pub(super) fn mover(&self, link: &str) -> Result<Option<(&'a Joint, Transform)>, ModelError> {
        let (_, mover, path) = self.climb(link)?;
        Ok(mover.map(|joint| (joint, path)))
    }

    /// Climbs fixed joints from a link: the highest link that it is rigidly fixed to, the joint that moves that link (none
    /// for the root), and the transform from that link.
    fn climb(&self, link: &str) -> Result<(&'a str, Option<&'a Joint>, Transform), ModelError> {
        let mut top = &*self.link(link)?.name;
        let mut path = Transform::IDENTITY;
        for _ in 0..=self.robot.joints.len() {
            match self
                .robot
                .joints
                .iter()
                .find(|joint| joint.child.link == top)
            {
                Some(joint) if joint.joint_type == JointType::Fixed => {
                    let origin = transform(&joint.origin, || {
                        format!("the origin of joint `{}`", joint.name)
                    })?;
                    path = origin.then(&path);
                    top = &*self.link(&joint.parent.link)?.name;
                }
                mover => return Ok((top, mover, path)),
            }
        }
        Err(misfit(
            format!("link `{link}`"),
            "fixed to itself in a loop",
            "a tree of links",
        ))
    }
}

/// A URDF pose as a transform: rotation about the fixed axes x, y, z by roll, pitch, yaw.
pub(super) fn transform(pose: &Pose, what: impl Fn() -> String) -> Result<Transform, ModelError> {
    let (xyz, rpy) = (pose.xyz.0, pose.rpy.0);
    if !(finite(&xyz) && finite(&rpy)) {
        return Err(misfit(
            what(),
            format!("xyz {xyz:?} rpy {rpy:?}"),
            "finite numbers (m, rad)",
        ));
    }
    let ((sr, cr), (sp, cp), (sy, cy)) = (
        libm::sincos(rpy[0]),
        libm::sincos(rpy[1]),
        libm::sincos(rpy[2]),
    );
    let roll = Matrix3::new(1.0, 0.0, 0.0, 0.0, cr, -sr, 0.0, sr, cr);
    let pitch = Matrix3::new(cp, 0.0, sp, 0.0, 1.0, 0.0, -sp, 0.0, cp);
    let yaw = Matrix3::new(cy, -sy, 0.0, sy, cy, 0.0, 0.0, 0.0, 1.0);
    Ok(Transform {
        rotation: yaw * pitch * roll,
        translation_m: Vector3::from(xyz),
    })
}

pub(super) fn finite(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite())
}
