//! Loader: from a URDF and its robot file to a [`RobotModel`], or to the list of all problems.
//!
//! A robot has one or two hands. Each has an arm of up to 7 joints that carries a palm, and 2 to 4
//! fingertips on chains of up to 4 joints; at most 16 joints per hand. Joints are revolute,
//! continuous or prismatic. Finger joints may mimic other joints of the hand. Joints that move no
//! fingertip stay at zero.
//!
//! Collision shapes become capsules: a cylinder or box is replaced by the capsule around it. Meshes
//! cannot be converted: they are rejected for two arms, which must keep apart, and ignored for one
//! arm.

mod collision;
mod error;
mod framed;
mod hand;
mod joint;
mod location;
mod tip;
mod tree;

use std::format;
use std::string::String;
use std::vec::Vec;

use error::Findings;
pub(crate) use error::problem;
pub use error::{ModelError, ModelFile, ModelProblem};
use hand::load_hand;
use joint::{joint_axis, load_joint};
use location::bad_number;
use tree::Tree;

use crate::model::HandModel;
use crate::robot::RobotModel;
use crate::robot_file::RobotFile;
use crate::side::HandSide;

impl RobotModel {
    /// Loads a robot from the texts of a URDF and a robot file.
    ///
    /// # Errors
    /// [`ModelError`] if a text is invalid, or with all problems found.
    pub fn load(urdf_text: &str, robot_file: &str) -> Result<RobotModel, ModelError> {
        let file = RobotFile::parse(robot_file)?;
        let robot = read(urdf_text)?;
        let mut findings = Findings::new(urdf_text, robot_file);
        let tree = Tree::new(&robot, &mut findings)?;
        check_entries(&tree, &file, &mut findings);
        let entries = [&file.hands.left, &file.hands.right];
        if entries.iter().all(|entry| entry.is_none()) {
            let needs = "[hands.left] or [hands.right]";
            findings.add(problem("the robot file", "without a hand", needs).in_robot_file());
        }
        let alone = entries.iter().any(|entry| entry.is_none());
        let mut hand = |side: HandSide| match entries[side.index()] {
            None => Some(HandModel::absent(side)),
            Some(entry) => load_hand(&tree, side, entry, &file.joints, alone, &mut findings),
        };
        let hands = [hand(HandSide::Left), hand(HandSide::Right)];
        let [Some(left), Some(right)] = hands else {
            return findings.into_result(None);
        };
        check_apart(&left, &right, &mut findings);
        let hands = [left, right];
        let mut robot = findings.into_result(Some(RobotModel { hands }))?;
        // Capabilities are found by inverse kinematics, which needs a valid robot.
        robot
            .hands
            .iter_mut()
            .for_each(HandModel::find_capabilities);
        Ok(robot)
    }
}

/// Parses a URDF. A number that cannot be read is named with its line.
fn read(urdf_text: &str) -> Result<urdf_rs::Robot, ModelError> {
    urdf_rs::read_from_string(urdf_text).map_err(|error| match bad_number(urdf_text) {
        Some(bad) => {
            let needs = match &*bad.value {
                value if value.contains('$') => "numbers; expand the file with `xacro` first",
                value if value.contains(',') => "numbers with a decimal point, separated by spaces",
                _ => "numbers",
            };
            let item = format!("attribute {}", bad.attribute);
            let was = format!("{:?}", bad.value);
            ModelError::from(problem(item, was, needs).at_line(bad.line))
        }
        None => error.into(),
    })
}

/// Returns one sentence for each collision shape that was ignored or approximated.
///
/// # Errors
/// [`ModelError`] if a text is invalid.
pub(crate) fn remarks(urdf_text: &str, robot_file: &str) -> Result<Vec<String>, ModelError> {
    let file = RobotFile::parse(robot_file)?;
    let robot = read(urdf_text)?;
    let tree = Tree::new(&robot, &mut Findings::new(urdf_text, robot_file))?;
    Ok(collision::remarks(&tree, &file))
}

/// Checks every joint entry of the robot file, including joints that belong to no hand.
fn check_entries(tree: &Tree, file: &RobotFile, findings: &mut Findings) {
    for (name, entry) in &file.joints {
        match tree.joint(name) {
            Err(problem) => findings.add(problem),
            Ok(joint) if joint.joint_type == urdf_rs::JointType::Fixed => {
                let item = format!("the type of joint `{name}`");
                let needs = "a moving joint, or no entry in the robot file";
                findings.add(problem(item, "fixed", needs));
            }
            Ok(joint) => {
                let _ = load_joint(joint, Some(entry), findings);
                let _ = findings.value_of(joint_axis(joint));
            }
        }
    }
}

/// Checks that no joint moves both hands.
fn check_apart(left: &HandModel, right: &HandModel, findings: &mut Findings) {
    for joint in left.joints() {
        if right.joints().iter().any(|other| other.name == joint.name) {
            let item = format!("joint `{}`", joint.name);
            findings.add(problem(item, "part of both hands", "a joint of one"));
        }
    }
}
