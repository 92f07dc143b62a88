//! Interface of a module: its inputs, its proposal, and its roles in the rules of tasks.

use crate::path::Path;
use crate::perception::{Percept, StiffnessFit};
use crate::settings::Settings;
use crate::tasks::BehaviourTable;
use crate::teleop::TeleopTarget;
use crate::thresholds::Thresholds;
use nalgebra::Vector3;
use robot_model::{Compression, GRASP_SIDES, GraspPose, Transform};
use shm_schemas::{ModuleId, Reason};

/// Inputs of a module other than the percept.
#[derive(Clone, Copy, Debug)]
pub struct Context<'a> {
    /// Tunable parameters.
    pub settings: &'a Settings,
    /// Time since the previous tick, s.
    pub step_s: f64,
    /// F_1 and F_2 for the present object.
    pub thresholds: Thresholds,
    /// Minimum normal force per grasp side, N: F_1 at first touch, less once the object is carried.
    pub min_force_n: f64,
    /// Every side has touched since the approach began.
    pub all_touched: bool,
    /// Total measured closing since every side touched, m.
    pub closing_m: f64,
    /// Compression of the fingertips under force.
    pub compression: Compression,
    /// Distance over which the object was carried, m.
    pub carried_m: f64,
    /// Only the hand carries the object, as far as verified.
    pub suspended: bool,
    /// Lift verification minimises the grip, just above the support, where a slip is harmless.
    pub minimises_grip: bool,
    /// The present ratio of grip force to load has passed lift verification. The force pattern is
    /// then no evidence of slip.
    pub verified: bool,
    /// Present grip relative to the verified one; `None` without lift verification.
    pub verified_grip: Option<VerifiedGrip>,
    /// Behaviour table of the task.
    pub table: Option<&'a BehaviourTable>,
    /// Path of the present step.
    pub path: &'a Path,
    /// Arbitrated factor on the path speed, −1 (back) to 1.
    pub carry_scale: f64,
    /// Arbitrated closing speed of each grasp side in the previous tick, m/s.
    pub closing_m_s: [f64; GRASP_SIDES],
    /// Commanded grasp pose.
    pub pose: &'a GraspPose,
    /// Present closing axis, base frame, unit length, including the rotation of the wrist.
    pub closing_axis: Vector3<f64>,
    /// Direction of rotation, seen from above: 1 anticlockwise, −1 clockwise.
    pub turning: f64,
    /// The wrist rotates the whole hand, where fingertips would pass each other.
    pub turns_by_wrist: bool,
    /// Depth of a lowering step below the end of its path, m; `None` in other steps.
    pub lowering_m: Option<f64>,
    /// Teleoperation target; `None` brakes.
    pub teleop_target: Option<&'a TeleopTarget>,
    /// Measured frame of each fingertip.
    pub base_from_tip: &'a [Transform],
    /// Measured mean of the fingertips of each grasp side, base frame, m.
    pub side_m: [Vector3<f64>; GRASP_SIDES],
    /// Ratio of tactile to joint-estimated force, ≥ 1. Limits opening when the skin reports too
    /// much.
    pub tactile_over_torque: f64,
    /// Ratio of joint-estimated to tactile force, ≥ 1. Limits closing when the skin reports too
    /// little.
    pub torque_over_tactile: f64,
}

/// Present grip of an object, relative to the one that lift verification has shown to hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerifiedGrip {
    /// Filtered net load across the closing axis, N.
    pub load_n: f64,
    /// Load that the present grip force holds, N.
    pub held_n: f64,
    /// Mean load of the last second, N.
    pub mean_n: f64,
    /// Standard deviation of the load, N.
    pub scatter_n: f64,
    /// Normal force of each side, N.
    pub normal_n: [f64; GRASP_SIDES],
    /// Normal force of each side at the verification, N.
    pub verified_normal_n: [f64; GRASP_SIDES],
    /// Distance by which the fingertips are closer to each other than at the verification, m.
    pub closed_m: f64,
}

/// Output of one module in one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proposal {
    /// The condition of the module holds.
    pub active: bool,
    /// Requested closing speed of each grasp side, m/s; 0 for none, negative to open unless a
    /// module closes.
    pub closing_m_s: [f64; GRASP_SIDES],
    /// Highest tolerated closing speed of each grasp side, m/s; negative demands opening.
    pub closing_ceiling_m_s: [f64; GRASP_SIDES],
    /// Highest tolerated factor on the path speed, −1 (back) to 1.
    pub carry_ceiling: f64,
    /// Requested pose of the hand.
    pub pose: Option<PoseCommand>,
    /// Conclusion about the task.
    pub verdict: Verdict,
    /// Evidence about the object.
    pub finding: Finding,
}

/// Evidence about the held object, independent of friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Finding {
    /// It slips through the fingers.
    pub slips: bool,
    /// Only the hand carries it.
    pub suspended: bool,
    /// The grip is to be minimised, before a verification.
    pub minimises_grip: bool,
    /// The zero of a sensor has moved, because the grip force does not match the opening.
    pub drifts: bool,
}

/// Requested hand pose.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PoseCommand {
    /// Grasp pose.
    pub pose: GraspPose,
    /// The pose includes the finger opening, instead of the closing speeds.
    pub with_fingers: bool,
    /// The path has ended.
    pub arrived: bool,
}

/// A module's conclusion about the task.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Verdict {
    /// No conclusion.
    #[default]
    None,
    /// Stiffness of the object.
    Stiffness(StiffnessFit),
    /// The step has achieved its purpose.
    Done,
    /// The object cannot be handled.
    Refuse(Reason),
}

impl Default for Proposal {
    fn default() -> Self {
        Self {
            active: false,
            closing_m_s: [0.0; GRASP_SIDES],
            closing_ceiling_m_s: [f64::INFINITY; GRASP_SIDES],
            carry_ceiling: 1.0,
            pose: None,
            verdict: Verdict::None,
            finding: Finding::default(),
        }
    }
}

/// Properties of a module that the rules of tasks check.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Roles {
    /// Determines the hand pose. A step that moves has exactly one such module.
    pub moves_hand: bool,
    /// Closes the fingers. The step then requires Module 3.
    pub closes_fingers: bool,
    /// Ends a step by its verdict (Module 4).
    pub concludes: bool,
    /// Resets at every step, not only after the release of the object.
    pub resets_each_step: bool,
}

impl Roles {
    /// No roles.
    pub const NONE: Self = Self {
        moves_hand: false,
        closes_fingers: false,
        concludes: false,
        resets_each_step: false,
    };
}

/// One behaviour of the paper.
pub trait Module {
    /// Name on the bus, in tasks and in events.
    const ID: ModuleId;
    /// Properties that the rules of tasks check.
    const ROLES: Roles = Roles::NONE;

    /// Evaluates the module from sensor information.
    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal;
}

/// Returns the smallest and largest normal force over the grasp sides, N.
#[must_use]
pub fn force_range_n(percept: &Percept) -> (f64, f64) {
    percept
        .sides
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), finger| {
            (
                if finger.normal_n < low {
                    finger.normal_n
                } else {
                    low
                },
                if finger.normal_n > high {
                    finger.normal_n
                } else {
                    high
                },
            )
        })
}

/// Returns the total tangential force of the grasp sides, N.
#[must_use]
pub fn load_n(percept: &Percept) -> f64 {
    percept.sides.iter().map(|f| f.tangential_n).sum()
}

/// Returns the vertical force of the object on all gripping fingertips, base frame, N; negative for
/// a suspended object.
#[must_use]
pub fn force_up_n(percept: &Percept, base_from_tip: &[Transform]) -> f64 {
    net_force_n(percept, base_from_tip).z
}

/// Returns the part of a net force across the closing axis, N. Friction carries it.
pub(crate) fn across_axis_n(net_n: &Vector3<f64>, closing_axis: &Vector3<f64>) -> f64 {
    let across_n = net_n - closing_axis * net_n.dot(closing_axis);
    libm::sqrt(across_n.norm_squared())
}

/// Returns the sum of the forces of the object on all gripping fingertips, base frame, N.
#[must_use]
pub fn net_force_n(percept: &Percept, base_from_tip: &[Transform]) -> Vector3<f64> {
    percept
        .fingertips
        .iter()
        .zip(base_from_tip)
        .map(|(finger, base_from_tip)| base_from_tip.rotation * finger.force_tip_n)
        .sum()
}
