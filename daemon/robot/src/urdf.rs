//! The loader: a URDF and its robot file in, [`RobotModel`] out, or everything in them that does not fit.
//!
//! A robot fits if it has one or two hands, each of an arm of up to 7 joints that carries a palm, and of 2 to 4 fingertips that
//! the palm carries over up to 4 joints each; up to 16 joints a hand. Joints are revolute, continuous or prismatic; those
//! of a finger may mimic others of the hand. Collision shapes become capsules: a cylinder or a box is read as the
//! capsule that contains it. A mesh cannot be; it is refused where two arms must keep apart and passed over where there is one. Joints that move no fingertip stand at zero.

mod collision;
mod error;
mod framed;
mod hand;
mod joint;
mod tip;
mod tree;

use std::format;
use std::string::String;
use std::vec::Vec;

use error::Findings;
pub(crate) use error::misfit;
pub use error::{Misfit, ModelError, ModelFile};
use hand::load_hand;
use joint::{joint_axis, load_joint};
use tree::Tree;

use crate::model::HandModel;
use crate::robot::RobotModel;
use crate::robot_file::RobotFile;
use crate::side::Side;

impl RobotModel {
    /// Loads a robot from the texts of a URDF and of its robot file.
    ///
    /// # Errors
    /// [`ModelError`] if either is not what it says, or with everything in which they do not fit.
    pub fn load(urdf_text: &str, robot_file: &str) -> Result<RobotModel, ModelError> {
        let file = RobotFile::parse(robot_file)?;
        let robot = urdf_rs::read_from_string(urdf_text)?;
        let mut findings = Findings::new(urdf_text, robot_file);
        let tree = Tree::new(&robot, &mut findings);
        check_entries(&tree, &file, &mut findings);
        let entries = [&file.hands.left, &file.hands.right];
        if entries.iter().all(|entry| entry.is_none()) {
            let needs = "[hands.left] or [hands.right]";
            findings.add(misfit("the robot file", "without a hand", needs).of_robot_file());
        }
        let alone = entries.iter().any(|entry| entry.is_none());
        let mut hand = |side: Side| match entries[side.index()] {
            None => Some(HandModel::absent(side)),
            Some(entry) => load_hand(&tree, side, entry, &file.joints, alone, &mut findings),
        };
        let hands = [hand(Side::Left), hand(Side::Right)];
        let [Some(left), Some(right)] = hands else {
            return findings.unless_any(None);
        };
        check_apart(&left, &right, &mut findings);
        let hands = [left, right];
        let mut robot = findings.unless_any(Some(RobotModel { hands }))?;
        // Tried by the inverse kinematics, so only of a robot that is as it has to be.
        robot.hands.iter_mut().for_each(HandModel::find_abilities);
        Ok(robot)
    }
}

/// What of a robot's collision shapes is passed over or taken for something else, a sentence each.
///
/// # Errors
/// [`ModelError`] if either text is not what it says.
pub(crate) fn remarks(urdf_text: &str, robot_file: &str) -> Result<Vec<String>, ModelError> {
    let file = RobotFile::parse(robot_file)?;
    let robot = urdf_rs::read_from_string(urdf_text)?;
    let tree = Tree::new(&robot, &mut Findings::new(urdf_text, robot_file));
    Ok(collision::remarks(&tree, &file))
}

/// Every joint that the robot file speaks of must be one, of numbers that make sense: also those that no hand is found to have.
fn check_entries(tree: &Tree, file: &RobotFile, findings: &mut Findings) {
    for (name, entry) in &file.joints {
        match tree.joint(name) {
            Err(misfit) => findings.add(misfit),
            Ok(joint) if joint.joint_type == urdf_rs::JointType::Fixed => {
                let item = format!("the type of joint `{name}`");
                let needs = "a moving joint, or no entry in the robot file";
                findings.add(misfit(item, "fixed", needs));
            }
            Ok(joint) => {
                let _ = load_joint(joint, Some(entry), findings);
                let _ = findings.note(joint_axis(joint));
            }
        }
    }
}

/// No joint moves both hands.
fn check_apart(left: &HandModel, right: &HandModel, findings: &mut Findings) {
    for joint in left.joints() {
        if right.joints().iter().any(|other| other.name == joint.name) {
            let item = format!("joint `{}`", joint.name);
            findings.add(misfit(item, "part of both hands", "a joint of one"));
        }
    }
}
