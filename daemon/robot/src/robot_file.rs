//! The robot file: what a URDF does not say of a robot, as TOML.
//!
//! * **In:** the text. **Out:** a [`RobotFile`], or what TOML and its types find wrong. Whether it fits the URDF is found when
//!   both become a [`crate::RobotModel`].
//! * **Absent on purpose:** chains of joints: they follow from the URDF between its root, the palm and the tips.

use std::collections::BTreeMap;
use std::string::String;
use std::vec::Vec;

use serde::Deserialize;

/// What a URDF does not say.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotFile {
    /// Its URDF, from where the robot file is. Left out: the file of the same name that ends in `.urdf`.
    pub urdf: Option<String>,
    /// The hands: `left`, `right` or both.
    pub hands: Hands,
    /// Per joint of the URDF, by its name: what its servo is and where it rests.
    #[serde(default)]
    pub joints: BTreeMap<String, JointEntry>,
}

/// The hands of a robot.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hands {
    /// The hand at positive y.
    pub left: Option<HandEntry>,
    /// The hand at negative y.
    pub right: Option<HandEntry>,
}

/// One hand.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandEntry {
    /// The link that carries the fingers.
    pub palm: String,
    /// Direction of that link that points down in a grasp from above, in its own frame.
    pub down: [f64; 3],
    /// Where the hand rests, pointing down: the point between its fingertips, base frame, m. Left out: where the reference
    /// posture has it.
    pub home_m: Option<[f64; 3]>,
    /// Direction of the closing axis where it rests, degrees from the base's x. Left out: as the reference posture has it.
    pub home_yaw_deg: Option<f64>,
    /// Where objects stand that nobody placed: x and y, base frame, m. Left out: beneath where the hand rests.
    pub object_m: Option<[f64; 2]>,
    /// The box of grasps from above that every goal must lie in. Left out: whatever the hand has a posture for.
    pub workspace: Option<WorkspaceEntry>,
    /// How far open it rests, from pole to pole, m. Left out: as far as the reference posture has it.
    pub home_opening_m: Option<f64>,
    /// What its fingertips feel with. Left out: the paper's domes.
    pub skin: Option<SkinEntry>,
    /// Its fingertips, in the order of the sensor's frames.
    pub fingers: Vec<FingerEntry>,
}

/// A box of grasps from above, each the least and the greatest value, m.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorkspaceEntry {
    /// x of the point between the fingertips, base frame.
    pub x_m: [f64; 2],
    /// Its y.
    pub y_m: [f64; 2],
    /// Its height above the table.
    pub z_m: [f64; 2],
    /// Distance between the poles of the domes.
    pub opening_m: [f64; 2],
}

/// The skin of a hand's fingertips.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkinEntry {
    /// Where its elements sit: a [`shm_schemas::layout::NamedLayout`].
    pub layout: String,
    /// How far one fingertip gives way to a rigid block that presses with 1 N, m.
    pub compression_m: f64,
    /// How that grows with the force: 1 for a linear spring, such as a flat pad on a flat face; 0.5 for a dome.
    pub exponent: f64,
}

/// One fingertip.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FingerEntry {
    /// The link that carries the sensor.
    pub tip: String,
    /// Middle of the sensor's dome in that link, m. Left out: the link's origin.
    pub dome_m: Option<[f64; 3]>,
    /// Middle of its sensing face in that link, m, instead of `dome_m`: for faces that are no dome. It takes `facing`.
    pub face_m: Option<[f64; 3]>,
    /// Direction in which it feels, through the dome's pole, in that link. Left out: the link is turned as
    /// [`crate::HandPose::base_from_tip`] has it.
    pub facing: Option<[f64; 3]>,
    /// Radius of the dome, m. Left out: that of the link's one collision sphere; for a skin that is no dome, what its layout says.
    pub dome_radius_m: Option<f64>,
    /// The side from which it presses, 1 or 2: fingertips of one side press together against the other's.
    pub side: usize,
}

/// One joint. Angles in degrees or lengths in metres, as the joint turns or slides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointEntry {
    /// Reference posture of a revolute joint, degrees: what the inverse kinematics prefers where a task leaves freedom. The
    /// hand points down in it. Left out: 0.
    pub rest_deg: Option<f64>,
    /// Reference posture of a prismatic joint, m. Left out: 0.
    pub rest_m: Option<f64>,
    /// Stiffness of its servo, N·m/rad or N/m.
    pub stiffness: f64,
    /// Inertia that its servo moves, kg·m² or kg: for simulation.
    pub inertia: f64,
    /// Limits that the URDF lacks or that shall be others: rad or m.
    pub lower: Option<f64>,
    /// See `lower`.
    pub upper: Option<f64>,
    /// Top speed, rad/s or m/s, see `lower`.
    pub velocity: Option<f64>,
    /// Largest torque or force, N·m or N, see `lower`.
    pub effort: Option<f64>,
}

impl RobotFile {
    /// Reads the text of a robot file.
    ///
    /// # Errors
    /// What TOML says, with the place.
    pub fn parse(text: &str) -> Result<RobotFile, toml::de::Error> {
        toml::from_str(text)
    }
}
