//! Robot file: TOML that adds to a URDF the hands, fingertips, servos and home posture.
//!
//! * **Input:** text. **Output:** a [`RobotFile`], or all errors of TOML and its types.
//!   [`crate::RobotModel`] checks it against the URDF.
//! * **Not included:** chains of joints. They follow from the URDF between its root, the palm and
//!   the tips.

use std::collections::BTreeMap;
use std::string::String;
use std::vec::Vec;

use serde::Deserialize;

/// Data of a robot that a URDF lacks.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotFile {
    /// Path of the URDF, relative to the robot file. Default: same name, extension `.urdf`.
    pub urdf: Option<String>,
    /// Hands: `left`, `right` or both.
    pub hands: Hands,
    /// Servo and rest position per joint, by its name in the URDF.
    #[serde(default)]
    pub joints: BTreeMap<String, JointEntry>,
}

/// Hands of a robot.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hands {
    /// Hand at positive y.
    pub left: Option<HandEntry>,
    /// Hand at negative y.
    pub right: Option<HandEntry>,
}

/// One hand.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandEntry {
    /// Link that carries the fingers.
    pub palm: String,
    /// Direction of the palm that points down in a grasp from above, in the frame of the palm.
    pub down: [f64; 3],
    /// Home position of a hand that points down: the point between the fingertips, base frame, m.
    /// Default: from the reference posture.
    pub home_m: Option<[f64; 3]>,
    /// Direction of the closing axis at home, degrees from the base's x. Default: from the
    /// reference posture.
    pub home_yaw_deg: Option<f64>,
    /// Default object position: x and y, base frame, m. Default: below home.
    pub object_m: Option<[f64; 2]>,
    /// Box that limits grasps from above. Default: only reach limits them.
    pub workspace: Option<WorkspaceEntry>,
    /// Home opening from pole to pole, m. Default: from the reference posture.
    pub home_opening_m: Option<f64>,
    /// Tactile skin of the fingertips. Default: the domes of the paper.
    pub skin: Option<SkinEntry>,
    /// Fingertips, in the order of the sensor's frames.
    pub fingers: Vec<FingerEntry>,
}

/// Box of grasps from above; minimum and maximum of each value, m.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorkspaceEntry {
    /// x of the point between the fingertips, base frame.
    pub x_m: [f64; 2],
    /// y of the same point.
    pub y_m: [f64; 2],
    /// Height of the same point above the table.
    pub z_m: [f64; 2],
    /// Distance between the poles of the domes.
    pub opening_m: [f64; 2],
}

/// Skin of a hand's fingertips.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkinEntry {
    /// Element layout: a [`shm_schemas::layout::NamedLayout`].
    pub layout: String,
    /// Compression of one fingertip under a rigid flat block at 1 N, m.
    pub compression_m: f64,
    /// Exponent of compression over force: 1 for a linear spring, such as a flat pad on a flat
    /// face; 0.5 for a dome.
    pub exponent: f64,
}

/// One fingertip.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FingerEntry {
    /// Link that carries the sensor.
    pub tip: String,
    /// Centre of the sensor's dome in that link, m. Default: the link's origin.
    pub dome_m: Option<[f64; 3]>,
    /// Centre of the sensing face in that link, m, instead of `dome_m`, for faces that are not
    /// domes. Requires `facing`.
    pub face_m: Option<[f64; 3]>,
    /// Sensing direction, through the dome's pole, in that link. Default: from the link frame,
    /// which then follows [`crate::HandPose::base_from_tip`].
    pub facing: Option<[f64; 3]>,
    /// Radius of the dome, m. Default: radius of the link's only collision sphere; for a skin
    /// without domes, from its layout.
    pub dome_radius_m: Option<f64>,
    /// Grasp side, 1 or 2. Fingertips of one side press together against those of the other.
    pub side: usize,
}

/// One joint. Values in degrees or metres, for revolute or prismatic joints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointEntry {
    /// Reference position of a revolute joint, degrees. The inverse kinematics prefers it where a
    /// task leaves freedom. The hand points down in this posture. Default: 0.
    pub rest_deg: Option<f64>,
    /// Reference position of a prismatic joint, m. Default: 0.
    pub rest_m: Option<f64>,
    /// Servo stiffness, N·m/rad or N/m.
    pub stiffness: f64,
    /// Inertia that the servo moves, kg·m² or kg; for simulation.
    pub inertia: f64,
    /// Lower position limit, rad or m, if the URDF has none or another.
    pub lower: Option<f64>,
    /// Upper position limit; see `lower`.
    pub upper: Option<f64>,
    /// Speed limit, rad/s or m/s; see `lower`.
    pub velocity: Option<f64>,
    /// Torque or force limit, N·m or N; see `lower`.
    pub effort: Option<f64>,
}
