//! The URDF loader: text in, [`RobotModel`] out, or an error that names what does not fit.
//!
//! A URDF fits if its moving joints are the 22 revolute joints of [`JOINT_NAMES`] in that order, each mounted (through
//! any number of fixed joints) on the link that the joint before it moves, and its tip links exist with one collision
//! sphere, the dome. Dimensions, axes, offsets, fixed joints and limits are free. Collision shapes are cylinders,
//! capsules or spheres; a cylinder is read as the capsule that contains it.

mod collision;
mod error;
mod joint;
mod tree;

use std::format;
use std::path::Path;
use std::string::ToString;
use std::vec::Vec;

use urdf_rs::{JointType, Robot};

use collision::{dome_radius, load_capsules};
pub use error::ModelError;
pub(crate) use error::misfit;
use joint::{joint_axis, load_joint, reference_rad, turn_z_to};
use tree::{Tree, transform};

use crate::model::{
    HandModel, JOINT_NAMES, Joint, PARENT, RobotModel, Side, TIP_LINKS, TWO_HAND_ARM_URDF,
    finger_root,
};
use crate::sizes::{ARM_JOINTS, FINGER_JOINTS, FINGERS, HAND_JOINTS, ROBOT_JOINTS};
use crate::transform::Transform;

impl RobotModel {
    /// Loads a robot from the text of a URDF.
    ///
    /// # Errors
    /// [`ModelError`] if the text is not a URDF or the robot is not of this structure.
    pub fn from_urdf(text: &str) -> Result<RobotModel, ModelError> {
        let robot = urdf_rs::read_from_string(text)?;
        check_moving_joints(&robot)?;
        let tree = Tree::new(&robot)?;
        let left = load_hand(&tree, Side::Left)?;
        let right = load_hand(&tree, Side::Right)?;
        Ok(RobotModel {
            hands: [left, right],
        })
    }

    /// Loads a robot from a URDF file.
    ///
    /// # Errors
    /// [`ModelError`] if the file cannot be read, and as [`from_urdf`](Self::from_urdf).
    pub fn from_urdf_file(path: impl AsRef<Path>) -> Result<RobotModel, ModelError> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|source| ModelError::Read {
            path: path.to_path_buf(),
            source,
        })?;
        RobotModel::from_urdf(&text)
    }

    /// The built-in robot, from [`TWO_HAND_ARM_URDF`].
    ///
    /// # Errors
    /// None in a released crate: a test loads it.
    pub fn two_hand_arm() -> Result<RobotModel, ModelError> {
        RobotModel::from_urdf(TWO_HAND_ARM_URDF)
    }
}

fn check_moving_joints(robot: &Robot) -> Result<(), ModelError> {
    let moving: Vec<_> = robot
        .joints
        .iter()
        .filter(|joint| joint.joint_type != JointType::Fixed)
        .collect();
    for (index, (joint, needed)) in moving.iter().zip(JOINT_NAMES.as_flattened()).enumerate() {
        if joint.name != *needed {
            return Err(misfit(
                format!("moving joint {index} of the file"),
                format!("`{}`", joint.name),
                format!("`{needed}`"),
            ));
        }
        if joint.joint_type != JointType::Revolute || joint.mimic.is_some() {
            let kind = if joint.mimic.is_some() {
                "a mimic joint".to_string()
            } else {
                format!("{:?}", joint.joint_type)
            };
            return Err(misfit(
                format!("the type of joint `{needed}`"),
                kind,
                "an independent revolute joint",
            ));
        }
    }
    if moving.len() == ROBOT_JOINTS {
        Ok(())
    } else {
        Err(misfit(
            "the number of moving joints",
            moving.len(),
            format!("{ROBOT_JOINTS}: left 11, then right 11"),
        ))
    }
}

fn load_hand(tree: &Tree, side: Side) -> Result<HandModel, ModelError> {
    let names = &JOINT_NAMES[side.index()];
    let mut joints = [Joint::default(); HAND_JOINTS];
    let mut joint_from_link = [Transform::IDENTITY; HAND_JOINTS];
    let mut parent_from_joint = [Transform::IDENTITY; HAND_JOINTS];
    for (index, &name) in names.iter().enumerate() {
        let urdf = tree.joint(name)?;
        joints[index] = load_joint(name, urdf)?;
        let link_from_joint = turn_z_to(joint_axis(urdf)?);
        joint_from_link[index] = Transform {
            rotation: link_from_joint.rotation.transpose(),
            ..link_from_joint
        };
        let parent = PARENT[index];
        let parent_link = parent
            .map(|parent| tree.joint(names[parent]))
            .transpose()?
            .map(|joint| &*joint.child.link);
        let parent_from_link = parent.map_or(Transform::IDENTITY, |parent| joint_from_link[parent]);
        parent_from_joint[index] = parent_from_link
            .then(&tree.fixed_path(parent_link, &urdf.parent.link)?)
            .then(&transform(&urdf.origin, || {
                format!("the origin of joint `{name}`")
            })?)
            .then(&link_from_joint);
    }
    let mut distal_from_tip = [Transform::IDENTITY; FINGERS];
    let mut dome_radius_m = [0.0; FINGERS];
    for finger in 0..FINGERS {
        let distal = finger_root(finger) + FINGER_JOINTS - 1;
        let tip_link = TIP_LINKS[side.index()][finger];
        let path = tree.fixed_path(Some(&tree.joint(names[distal])?.child.link), tip_link)?;
        distal_from_tip[finger] = joint_from_link[distal].then(&path);
        dome_radius_m[finger] = dome_radius(tree, tip_link)?;
    }
    Ok(HandModel {
        side,
        joints,
        parent_from_joint,
        wrist_from_hand: joint_from_link[ARM_JOINTS - 1],
        distal_from_tip,
        dome_radius_m,
        reference_rad: reference_rad(side, &joints),
        capsules: load_capsules(tree, names, &joint_from_link)?,
    })
}
