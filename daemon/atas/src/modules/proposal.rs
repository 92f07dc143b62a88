//! What a module is: what it may know, what it may propose, and what the rules of tasks must know of it.

use crate::follow::Lead;
use crate::path::Path;
use crate::perception::{Percept, StiffnessFit};
use crate::settings::Settings;
use crate::tasks::BehaviourTable;
use crate::thresholds::Thresholds;
use nalgebra::{Matrix3, Vector3};
use robot_model::{Compression, GraspFrame, VIRTUAL_FINGERS};
use shm_schemas::{ModuleId, Reason};

/// What a module may know besides what the hand feels.
#[derive(Clone, Copy, Debug)]
pub struct Context<'a> {
    /// Every tunable number.
    pub settings: &'a Settings,
    /// Time since the tick before, s.
    pub step_s: f64,
    /// F_1 and F_2 for the present object.
    pub thresholds: Thresholds,
    /// Least force that each finger shall press with, N: F_1 at first touch, less once the object is carried.
    pub least_n: f64,
    /// Whether every finger has touched since the approach began.
    pub all_touched: bool,
    /// Total measured closing of the fingers since every finger touched, m.
    pub closing_m: f64,
    /// How far the fingertips give way to what presses them.
    pub tips: Compression,
    /// How far the hand has carried the object, m.
    pub carried_m: f64,
    /// Whether nothing but the hand carries the object, as far as anybody has tested.
    pub hangs: bool,
    /// Whether it is tried how gently the object can be held: it hangs just above its support, where a slip costs nothing and
    /// a test follows.
    pub tries: bool,
    /// Whether a test has proved that the object hangs, and the hand grips it no less firmly for its load than it did then: what the
    /// pattern of forces says of slipping is no evidence against that.
    pub proved: bool,
    /// The behaviour table of the task, if it has one.
    pub table: Option<&'a BehaviourTable>,
    /// The path of the present step.
    pub path: &'a Path,
    /// Factor on the hand's speed along its path that arbitration allows now, −1 (back) to 1.
    pub carry_scale: f64,
    /// Closing speed of each virtual finger that arbitration made of the tick before, m/s.
    pub closing_m_s: [f64; VIRTUAL_FINGERS],
    /// The commanded pose.
    pub frame: &'a GraspFrame,
    /// The closing axis as the hand stands, base frame, unit length: that of the pose, turned by what the wrist does for the fingertips.
    pub closing_axis: Vector3<f64>,
    /// Sense of turning, seen from above: 1 anticlockwise, −1 clockwise.
    pub turning: f64,
    /// Whether the hand turns as a whole, by its wrist, where fingertips would pass each other.
    pub turns_by_wrist: bool,
    /// How far a step that lowers may go down from the end of its path, m; `None` in other steps.
    pub lowering_m: Option<f64>,
    /// What a client that leads the hand wants of it in this step; `None` to brake, and in every task that nobody leads.
    pub lead: Option<&'a Lead>,
    /// Measured orientation of each fingertip: turns tip-frame forces into the base frame.
    pub base_from_tip: &'a [Matrix3<f64>],
    /// What the skin reports more than the joints bear, as a factor, at least 1. What opens the fingers must not trust the skin alone.
    pub overread: f64,
    /// What the joints bear more than the skin reports, the same way. What presses must not trust the skin alone.
    pub underread: f64,
}

/// What one module would do now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proposal {
    /// Whether the module's condition holds.
    pub active: bool,
    /// Closing speed that the module wants of each virtual finger, m/s; 0 for no wish, negative to open if nobody closes.
    pub closing_m_s: [f64; VIRTUAL_FINGERS],
    /// Highest closing speed that the module tolerates on each virtual finger, m/s; negative demands opening.
    pub closing_ceiling_m_s: [f64; VIRTUAL_FINGERS],
    /// Highest factor on the hand's speed along its path that the module tolerates, −1 (back) to 1.
    pub carry_ceiling: f64,
    /// Where the module wants the hand to be.
    pub pose: Option<PoseCommand>,
    /// What the module concludes.
    pub verdict: Verdict,
    /// What it has found out about the object, for those who must know.
    pub finding: Finding,
}

/// What a module has found out about the object in the hand, by evidence that needs no friction coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Finding {
    /// It slides through the fingers.
    pub slides: bool,
    /// Nothing but the hand carries it.
    pub hangs: bool,
    /// It is to be held as gently as it can be now; whether that was too gentle is tested afterwards.
    pub tries: bool,
}

/// A wanted pose of the hand.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PoseCommand {
    /// The pose.
    pub frame: GraspFrame,
    /// Whether the pose includes the opening of the fingers; otherwise they keep what the closing speeds made.
    pub with_fingers: bool,
    /// Whether the path has ended.
    pub arrived: bool,
}

/// A module's conclusion about the task.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Verdict {
    /// Nothing to conclude.
    #[default]
    None,
    /// The stiffness of the object.
    Stiffness(StiffnessFit),
    /// What the step is for has happened.
    Done,
    /// The object cannot be handled, because of this.
    Refuse(Reason),
}

impl Default for Proposal {
    fn default() -> Self {
        Self {
            active: false,
            closing_m_s: [0.0; VIRTUAL_FINGERS],
            closing_ceiling_m_s: [f64::INFINITY; VIRTUAL_FINGERS],
            carry_ceiling: 1.0,
            pose: None,
            verdict: Verdict::None,
            finding: Finding::default(),
        }
    }
}

/// What a module does besides proposing speeds: what the rules of a task must know of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Roles {
    /// Says where the hand goes: a step that moves has exactly one such module.
    pub moves_hand: bool,
    /// Closes fingers by itself: a step that has it needs Module 3 as well.
    pub closes_fingers: bool,
    /// Ends a step by its verdict: Module 4.
    pub concludes: bool,
    /// Begins anew with every step; the others remember until the object is let go.
    pub forgets_each_step: bool,
}

impl Roles {
    /// None of them.
    pub const NONE: Self = Self {
        moves_hand: false,
        closes_fingers: false,
        concludes: false,
        forgets_each_step: false,
    };
}

/// One behaviour of the paper.
pub trait Module {
    /// Its name on the bus, in tasks and in events.
    const ID: ModuleId;
    /// What the rules of a task must know of it.
    const ROLES: Roles = Roles::NONE;

    /// Says from sensor information whether it is active and what it would do.
    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal;
}

/// Smallest and largest normal force over the virtual fingers, N.
#[must_use]
pub fn force_range_n(percept: &Percept) -> (f64, f64) {
    percept.virtual_fingers.iter().fold(
        (f64::INFINITY, f64::NEG_INFINITY),
        |(low, high), finger| {
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
        },
    )
}

/// Tangential force that the virtual fingers carry together, N.
#[must_use]
pub fn load_n(percept: &Percept) -> f64 {
    percept.virtual_fingers.iter().map(|f| f.tangential_n).sum()
}

/// Vertical force of the object on all fingers that grip, base frame, N; negative while the object hangs.
#[must_use]
pub fn force_up_n(percept: &Percept, base_from_tip: &[Matrix3<f64>]) -> f64 {
    percept
        .fingers
        .iter()
        .zip(base_from_tip)
        .map(|(finger, base_from_tip)| (base_from_tip * finger.force_tip_n).z)
        .sum()
}
