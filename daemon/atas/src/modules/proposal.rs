//! Interface of a module: its inputs, its proposal, and its roles in the rules of tasks.

use crate::executor::HandMotion;
use crate::held_object::{HeldObject, LiftFinding};
use crate::path::Path;
use crate::perception::{Percept, StiffnessFit};
use crate::settings::Settings;
use crate::tasks::BehaviourTable;
use crate::teleop::TeleopTarget;
use robot_model::{GraspPose, PerSide};
use shm_schemas::{ModuleId, Reason};

/// Inputs of a module other than the percept.
#[derive(Clone, Copy, Debug)]
pub struct Context<'a> {
    /// Tunable parameters.
    pub settings: &'a Settings,
    /// Time since the previous tick, s.
    pub step_s: f64,
    /// Estimate of the object in the hand.
    pub object: &'a HeldObject,
    /// Motion of the hand.
    pub hand: &'a HandMotion<'a>,
    /// Path of the present step.
    pub path: &'a Path,
    /// Behaviour table of the task.
    pub table: Option<&'a BehaviourTable>,
    /// Direction of rotation, seen from above: 1 anticlockwise, −1 clockwise.
    pub turning: f64,
    /// Depth of a lowering step below the end of its path, m; `None` in other steps.
    pub lowering_m: Option<f64>,
    /// Teleoperation target; `None` brakes.
    pub teleop_target: Option<&'a TeleopTarget>,
}

/// Output of one module in one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proposal {
    /// The condition of the module holds.
    pub active: bool,
    /// Requested closing speed of each grasp side, m/s; 0 for none, negative to open unless a
    /// module closes.
    pub closing_m_s: PerSide<f64>,
    /// Highest tolerated closing speed of each grasp side, m/s; negative demands opening.
    pub closing_ceiling_m_s: PerSide<f64>,
    /// Highest tolerated factor on the path speed, −1 (back) to 1.
    pub carry_ceiling: f64,
    /// Requested pose of the hand.
    pub pose: Option<PoseCommand>,
    /// Conclusion about the task.
    pub verdict: Verdict,
    /// Result of lift verification.
    pub finding: LiftFinding,
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
            closing_m_s: PerSide::repeat(0.0),
            closing_ceiling_m_s: PerSide::repeat(f64::INFINITY),
            carry_ceiling: 1.0,
            pose: None,
            verdict: Verdict::None,
            finding: LiftFinding::None,
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
