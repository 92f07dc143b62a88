//! Tree of a URDF: the carrying joint of each link, and rigid transforms along fixed joints.

use std::collections::BTreeMap;
use std::format;
use std::string::String;
use std::vec::Vec;

use nalgebra::{Matrix3, Vector3};
use urdf_rs::{Joint, JointType, Link, Pose, Robot};

use super::error::{Findings, ModelProblem, problem};
use crate::transform::Transform;

/// Most links and joints. Design choice: ten times the largest public URDF.
const PARTS_MAX: usize = 2000;

/// URDF in which at most one joint carries each link.
pub(super) struct Tree<'a> {
    robot: &'a Robot,
    links: BTreeMap<&'a str, &'a Link>,
    joints: BTreeMap<&'a str, &'a Joint>,
    /// Joint that carries each link.
    carriers: BTreeMap<&'a str, &'a Joint>,
}

/// One moving joint on the path from the root to a link.
#[derive(Clone, Copy)]
pub(super) struct Step<'a> {
    pub(super) joint: &'a Joint,
    /// Transform from the link of the previous moving joint (the root for the first) to this
    /// joint's origin.
    pub(super) origin: Transform,
}

/// Path from the root to a link.
pub(super) struct Chain<'a> {
    pub(super) steps: Vec<Step<'a>>,
    /// Transform from the link of the last moving joint (the root without one) to the link.
    pub(super) end: Transform,
}

impl<'a> Tree<'a> {
    pub(super) fn new(robot: &'a Robot, findings: &mut Findings) -> Result<Tree<'a>, ModelProblem> {
        for (what, count) in [("links", robot.links.len()), ("joints", robot.joints.len())] {
            if count > PARTS_MAX {
                let needs = format!("at most {PARTS_MAX}");
                return Err(problem(format!("the number of {what}"), count, needs));
            }
        }
        let mut tree = Tree {
            robot,
            links: BTreeMap::new(),
            joints: BTreeMap::new(),
            carriers: BTreeMap::new(),
        };
        // The first of equal names counts.
        for link in &robot.links {
            tree.links.entry(&link.name).or_insert(link);
        }
        for joint in &robot.joints {
            tree.joints.entry(&joint.name).or_insert(joint);
            let child = &*joint.child.link;
            let first = *tree.carriers.entry(child).or_insert(joint);
            if !core::ptr::eq(first, joint) {
                let was = format!("the child of joints `{}` and `{}`", first.name, joint.name);
                let needs = "one joint that carries it";
                findings.add(problem(format!("link `{child}`"), was, needs));
            }
        }
        Ok(tree)
    }

    pub(super) fn robot(&self) -> &'a Robot {
        self.robot
    }

    pub(super) fn joint(&self, name: &str) -> Result<&'a Joint, ModelProblem> {
        let found = self.joints.get(name).copied();
        found.ok_or_else(|| problem(format!("joint `{name}`"), "missing", "a joint of this name"))
    }

    pub(super) fn link(&self, name: &str) -> Result<&'a Link, ModelProblem> {
        let found = self.links.get(name).copied();
        found.ok_or_else(|| problem(format!("link `{name}`"), "missing", "a link of this name"))
    }

    /// Returns the moving joints from the root to a link.
    pub(super) fn chain(&self, link: &str) -> Result<Chain<'a>, ModelProblem> {
        let mut steps = Vec::new();
        let (_, mut mover, end) = self.climb(link)?;
        while let Some(joint) = mover {
            if steps.len() >= self.robot.joints.len() {
                return Err(looped(link));
            }
            let (_, before, path) = self.climb(&joint.parent.link)?;
            let own = transform(&joint.origin, || {
                format!("the origin of joint `{}`", joint.name)
            })?;
            let origin = path.then(&own);
            steps.push(Step { joint, origin });
            mover = before;
        }
        steps.reverse();
        Ok(Chain { steps, end })
    }

    /// Returns the joint that moves a link, with the fixed transform from that joint's child link;
    /// `None` for the base.
    pub(super) fn mover(&self, link: &str) -> Result<Option<(&'a Joint, Transform)>, ModelProblem> {
        let (_, mover, path) = self.climb(link)?;
        Ok(mover.map(|joint| (joint, path)))
    }

    /// Follows fixed joints upwards from a link. Returns the highest link that it is rigidly fixed
    /// to, the joint that moves that link (none for the root), and the transform from that link.
    fn climb(&self, link: &str) -> Result<(&'a str, Option<&'a Joint>, Transform), ModelProblem> {
        let mut top = &*self.link(link)?.name;
        let mut path = Transform::IDENTITY;
        for _ in 0..=self.robot.joints.len() {
            match self.carriers.get(top).copied() {
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
        Err(looped(link))
    }
}

fn looped(link: &str) -> ModelProblem {
    problem(
        format!("link `{link}`"),
        "fixed to itself in a loop",
        "a tree of links",
    )
}

/// Converts a URDF pose to a transform: rotation about the fixed axes x, y, z by roll, pitch, yaw.
pub(super) fn transform(pose: &Pose, what: impl Fn() -> String) -> Result<Transform, ModelProblem> {
    let (xyz, rpy) = (pose.xyz.0, pose.rpy.0);
    if !(finite(&xyz) && finite(&rpy)) {
        return Err(problem(
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
