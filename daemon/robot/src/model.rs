//! The robot as fixed-size data: two hands, each a tree of eleven joints, with limits and mounting transforms.

use core::ops::Range;

use nalgebra::Vector3;

use crate::capsule::Capsules;
use crate::sizes::{ARM_JOINTS, FINGER_JOINTS, FINGERS, HAND_JOINTS, HandVector, ROBOT_JOINTS};
use crate::transform::Transform;

/// The built-in robot's URDF.
pub const TWO_HAND_ARM_URDF: &str = include_str!("../two_hand_arm.urdf");

/// Which of the two arms with its hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Side {
    /// The arm at positive y.
    Left,
    /// The arm at negative y.
    Right,
}

impl Side {
    /// Both sides in the order of the robot's joints.
    pub const BOTH: [Side; 2] = [Side::Left, Side::Right];

    /// 0 for left, 1 for right: the position in every per-hand array.
    #[must_use]
    pub const fn index(self) -> usize {
        match self {
            Side::Left => 0,
            Side::Right => 1,
        }
    }

    /// Sign of this side's y: +1 left, −1 right. A mirrored quantity is the right one times minus this.
    #[must_use]
    pub const fn y_sign(self) -> f64 {
        match self {
            Side::Left => 1.0,
            Side::Right => -1.0,
        }
    }

    /// Index of this side's first joint in the robot's order.
    #[must_use]
    pub const fn first_joint(self) -> usize {
        self.index() * HAND_JOINTS
    }

    /// Positions of this side's joints in a vector of the whole robot.
    #[must_use]
    pub const fn joint_range(self) -> Range<usize> {
        self.first_joint()..self.first_joint() + HAND_JOINTS
    }
}

macro_rules! joint_names {
    ($side:literal) => {
        [
            concat!($side, "_shoulder_yaw"),
            concat!($side, "_shoulder_pitch"),
            concat!($side, "_elbow_pitch"),
            concat!($side, "_wrist_pitch"),
            concat!($side, "_wrist_roll"),
            concat!($side, "_finger1_root"),
            concat!($side, "_finger1_knuckle"),
            concat!($side, "_finger1_distal"),
            concat!($side, "_finger2_root"),
            concat!($side, "_finger2_knuckle"),
            concat!($side, "_finger2_distal"),
        ]
    };
}

/// Names of the joints, `[side][joint]`, in the robot's order. A URDF must use exactly these, in this order.
pub const JOINT_NAMES: [[&str; HAND_JOINTS]; 2] = [joint_names!("left"), joint_names!("right")];

/// Names of the links that carry the tip frames, `[side][finger]`.
pub const TIP_LINKS: [[&str; FINGERS]; 2] = [
    ["left_finger1_tip", "left_finger2_tip"],
    ["right_finger1_tip", "right_finger2_tip"],
];

/// One revolute joint: its name and what it can do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Joint {
    /// Name, one of [`JOINT_NAMES`].
    #[cfg_attr(feature = "serde", serde(deserialize_with = "joint_name"))]
    pub name: JointName,
    /// Lower position limit, radians.
    pub lower_rad: f64,
    /// Upper position limit, radians, above the lower one.
    pub upper_rad: f64,
    /// Speed limit, radians per second, positive.
    pub velocity_max_rad_s: f64,
    /// Torque limit, newton metres, not negative.
    pub effort_max_n_m: f64,
}

/// A joint's name. The alias keeps serde from borrowing it from what is read.
type JointName = &'static str;

/// The name of ours that is the one read.
#[cfg(feature = "serde")]
fn joint_name<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<JointName, D::Error> {
    let read = <&str as serde::Deserialize>::deserialize(deserializer)?;
    let ours = JOINT_NAMES.iter().flatten().find(|name| **name == read);
    ours.copied()
        .ok_or_else(|| serde::de::Error::custom("a joint with a name that no joint has"))
}

/// One arm with its hand: five arm joints, then three joints of finger 1, then three of finger 2.
///
/// Each joint's frame is the URDF's joint frame turned so that its z is the joint's axis: forward kinematics then
/// needs one rotation about z per joint whatever axes the URDF chose.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HandModel {
    pub(crate) side: Side,
    pub(crate) joints: [Joint; HAND_JOINTS],
    /// Transform from the frame of the joint before ([`PARENT`]) to this joint's frame at zero.
    pub(crate) parent_from_joint: [Transform; HAND_JOINTS],
    /// Transform from the last arm joint's frame to the hand link's frame.
    pub(crate) wrist_from_hand: Transform,
    /// Transform from each distal joint's frame to the tip frame.
    pub(crate) distal_from_tip: [Transform; FINGERS],
    pub(crate) dome_radius_m: [f64; FINGERS],
    pub(crate) reference_rad: HandVector,
    /// Collision capsules, each in the frame of the joint that moves it.
    pub(crate) capsules: Capsules,
}

/// The joint before each joint within a hand; the first is mounted on the base, both fingers on the last arm joint.
pub(crate) const PARENT: [Option<usize>; HAND_JOINTS] = [
    None,
    Some(0),
    Some(1),
    Some(2),
    Some(3),
    Some(4),
    Some(5),
    Some(6),
    Some(4),
    Some(8),
    Some(9),
];

/// Hand joint index of the first joint (the root) of a finger.
#[must_use]
pub const fn finger_root(finger: usize) -> usize {
    ARM_JOINTS + FINGER_JOINTS * finger
}

impl HandModel {
    /// Which side this is.
    #[must_use]
    pub fn side(&self) -> Side {
        self.side
    }

    /// The joints of the hand in order: arm 5, finger 1, finger 2.
    #[must_use]
    pub fn joints(&self) -> &[Joint; HAND_JOINTS] {
        &self.joints
    }

    /// Index of the first joint of this hand in the robot's order.
    #[must_use]
    pub fn first_joint(&self) -> usize {
        self.side.first_joint()
    }

    /// Radius of the sensor dome of each finger, metres.
    #[must_use]
    pub fn dome_radius_m(&self) -> [f64; FINGERS] {
        self.dome_radius_m
    }

    /// The posture that the inverse kinematics prefers where the task leaves freedom, radians, inside the limits:
    /// elbow up, hand straight down over the table, fingers half open.
    #[must_use]
    pub fn reference_rad(&self) -> &HandVector {
        &self.reference_rad
    }

    /// Position of the first joint at zero, in the base frame, metres: bearings of this arm are seen from here.
    #[must_use]
    pub fn shoulder_m(&self) -> Vector3<f64> {
        self.parent_from_joint[0].translation_m
    }

    /// The same hand with longer links: the mounting of each joint, and of each tip on its distal joint, longer by so much
    /// along itself, m. What is mounted in place stays there. For simulating a robot that is not quite as its model says.
    #[must_use]
    pub fn with_longer_links(&self, links_m: &HandVector, tips_m: &[f64; FINGERS]) -> Self {
        let mut hand = self.clone();
        let links = hand.parent_from_joint.iter_mut().zip(links_m.iter());
        let tips = hand.distal_from_tip.iter_mut().zip(tips_m);
        for (mounting, by_m) in links.chain(tips) {
            let along = mounting.translation_m.try_normalize(0.0);
            mounting.translation_m += along.unwrap_or_default() * *by_m;
        }
        hand
    }

    /// Whether every joint is finite and inside its position limits (limits included).
    #[must_use]
    pub fn within_limits(&self, q_rad: &HandVector) -> bool {
        self.joints
            .iter()
            .zip(q_rad.iter())
            .all(|(joint, &q)| q >= joint.lower_rad && q <= joint.upper_rad)
    }
}

/// The whole robot: left hand, then right hand. Fixed size, no heap.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotModel {
    pub(crate) hands: [HandModel; 2],
}

impl RobotModel {
    /// The arm with hand of one side.
    #[must_use]
    pub fn hand(&self, side: Side) -> &HandModel {
        &self.hands[side.index()]
    }

    /// The joint at a robot index (left 0–10, right 11–21), `None` beyond.
    #[must_use]
    pub fn joint(&self, index: usize) -> Option<&Joint> {
        self.joints().nth(index)
    }

    /// All joints in the robot's order.
    pub fn joints(&self) -> impl Iterator<Item = &Joint> {
        self.hands.iter().flat_map(|hand| hand.joints.iter())
    }
}

const _: () =
    assert!(ROBOT_JOINTS == 2 * HAND_JOINTS && HAND_JOINTS == ARM_JOINTS + FINGERS * FINGER_JOINTS);
