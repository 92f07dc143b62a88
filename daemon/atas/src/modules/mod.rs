//! The program modules of the paper (section II, Fig. 4): one file each, in parallel, without priority.
//!
//! In: what the hand feels ([`Percept`]) and what it is about ([`Context`]). Out: one [`Proposal`] per module. Every
//! module says from sensor information whether it is active and what it would do; none knows of another, and the order
//! of the list means nothing ([`crate::arbitration`] merges by rules that do not depend on it). That is what separates
//! ATAS from subsumption.
//!
//! | file | module | paper |
//! |---|---|---|
//! | `first_touch` | 1: enhance until F_n > F_1 | II.b (1) |
//! | `slip` | 2: enhance while slipping, dF_t > dr | II.b (1) |
//! | `force_limit` | 3: never enhance above F_2 | II.b (1) |
//! | `relax` | gives back force that friction does not need | ours |
//! | `load_test` | tugs back once in a lift: does the object hang? | ours |
//! | `probe` | stiffness within 100 ms of the first touch, refined while the force grows | II.b (1) |
//! | `contact_guard` | turns back what touches something on its way | ours |
//! | `carry` | moves the hand along the step's path | II.b (1), (3) |
//! | `trajectory` | 0: the square trajectory, and what contact makes of it | II.b (2) |
//! | `terminate_screw` | 4: concludes screwing at dF_t > 1.4 dF_max | II.b (2) |
//! | `transfer` | 0': conveys and sets down | II.b (3) |
//! | `release_placed` | 4: concludes placing on upward force | II.b (3) |
//! | `slip_reaction` | a baseline to compare with; in no built-in task | Romano et al. 2011 |

mod carry;
mod contact_guard;
mod first_touch;
mod force_limit;
mod load_test;
mod probe;
mod relax;
mod release_placed;
mod slip;
mod slip_reaction;
mod terminate_screw;
mod trajectory;
mod transfer;

use crate::path::Path;
use crate::perception::{Percept, StiffnessFit};
use crate::settings::Settings;
use crate::thresholds::Thresholds;
use carry::Carry;
use contact_guard::ContactGuard;
use first_touch::FirstTouch;
use force_limit::ForceLimit;
pub(crate) use force_limit::RELEASE_SHARE;
use load_test::LoadTest;
use nalgebra::Matrix3;
use probe::Probe;
use relax::Relax;
use release_placed::ReleasePlaced;
use robot_model::{FINGERS, GraspFrame};
use shm_schemas::{ModuleId, Reason};
use slip::Slip;
use slip_reaction::SlipReaction;
use terminate_screw::TerminateScrew;
use trajectory::Trajectory;
use transfer::Transfer;

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
    /// How far the hand has carried the object, m.
    pub carried_m: f64,
    /// The path of the present step.
    pub path: &'a Path,
    /// Factor on the hand's speed along its path that arbitration allows now, −1 (back) to 1.
    pub carry_scale: f64,
    /// Closing speed of each finger that arbitration made of the tick before, m/s.
    pub closing_m_s: [f64; FINGERS],
    /// The commanded pose.
    pub frame: &'a GraspFrame,
    /// Sense of turning, seen from above: 1 anticlockwise, −1 clockwise.
    pub turning: f64,
    /// How far a step that lowers may go down from the end of its path, m; `None` in other steps.
    pub lowering_m: Option<f64>,
    /// Measured orientation of each fingertip: turns tip-frame forces into the base frame.
    pub base_from_tip: &'a [Matrix3<f64>; FINGERS],
}

/// What one module would do now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proposal {
    /// Whether the module's condition holds.
    pub active: bool,
    /// Closing speed that the module wants of each finger, m/s; 0 for no wish, negative to open if nobody closes.
    pub closing_m_s: [f64; FINGERS],
    /// Highest closing speed that the module tolerates on each finger, m/s; negative demands opening.
    pub closing_ceiling_m_s: [f64; FINGERS],
    /// Highest factor on the hand's speed along its path that the module tolerates, −1 (back) to 1.
    pub carry_ceiling: f64,
    /// Where the module wants the hand to be.
    pub pose: Option<PoseCommand>,
    /// What the module concludes.
    pub verdict: Verdict,
}

/// A wanted pose of the hand.
#[derive(Clone, Copy, Debug, PartialEq)]
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
            closing_m_s: [0.0; FINGERS],
            closing_ceiling_m_s: [f64::INFINITY; FINGERS],
            carry_ceiling: 1.0,
            pose: None,
            verdict: Verdict::None,
        }
    }
}

/// One behaviour of the paper.
pub trait Module {
    /// Says from sensor information whether it is active and what it would do.
    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal;
}

/// Number of modules.
pub const COUNT: usize = 13;

/// Which modules a step of a task consists of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Selection(u32);

impl Selection {
    /// The modules with these names.
    #[must_use]
    pub const fn of(modules: &[ModuleId]) -> Self {
        let mut bits = 0;
        let mut i = 0;
        while i < modules.len() {
            bits |= 1 << modules[i].0;
            i += 1;
        }
        Self(bits)
    }

    /// No modules.
    pub const NONE: Self = Self(0);

    /// These modules and those.
    #[must_use]
    pub const fn and(self, more: Self) -> Self {
        Self(self.0 | more.0)
    }

    /// Whether a module is among them.
    #[must_use]
    pub const fn contains(self, module: ModuleId) -> bool {
        self.0 >> module.0 & 1 == 1
    }
}

/// The modules of one hand, with their memories.
#[derive(Clone, Debug, Default)]
pub struct Modules {
    carry: Carry,
    first_touch: FirstTouch,
    probe: Probe,
    slip: Slip,
    force_limit: ForceLimit,
    relax: Relax,
    transfer: Transfer,
    release_placed: ReleasePlaced,
    trajectory: Trajectory,
    terminate_screw: TerminateScrew,
    contact_guard: ContactGuard,
    load_test: LoadTest,
    slip_reaction: SlipReaction,
}

/// The modules in the order of their proposals. The order carries no meaning.
pub const IDS: [ModuleId; COUNT] = [
    ModuleId::CARRY,
    ModuleId::FIRST_TOUCH,
    ModuleId::PROBE,
    ModuleId::SLIP,
    ModuleId::FORCE_LIMIT,
    ModuleId::RELAX,
    ModuleId::TRANSFER,
    ModuleId::RELEASE_PLACED,
    ModuleId::TRAJECTORY,
    ModuleId::TERMINATE_SCREW,
    ModuleId::CONTACT_GUARD,
    ModuleId::LOAD_TEST,
    ModuleId::SLIP_REACTION,
];

impl Modules {
    /// Evaluates every selected module; the others propose nothing.
    pub fn evaluate(
        &mut self,
        selection: Selection,
        percept: &Percept,
        context: &Context<'_>,
    ) -> [Proposal; COUNT] {
        let list: [&mut dyn Module; COUNT] = [
            &mut self.carry,
            &mut self.first_touch,
            &mut self.probe,
            &mut self.slip,
            &mut self.force_limit,
            &mut self.relax,
            &mut self.transfer,
            &mut self.release_placed,
            &mut self.trajectory,
            &mut self.terminate_screw,
            &mut self.contact_guard,
            &mut self.load_test,
            &mut self.slip_reaction,
        ];
        let mut proposals = [Proposal::default(); COUNT];
        for ((module, id), proposal) in list.into_iter().zip(IDS).zip(&mut proposals) {
            if selection.contains(id) {
                *proposal = module.evaluate(percept, context);
            }
        }
        proposals
    }

    /// Forgets the present object.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// A new step begins: what moves the hand, or waits for the end of the step, starts afresh.
    pub fn restart_path(&mut self) {
        self.carry = Carry::default();
        self.transfer = Transfer::default();
        self.release_placed = ReleasePlaced::default();
        self.trajectory = Trajectory::default();
        self.terminate_screw = TerminateScrew::default();
    }
}

/// Smallest and largest normal force over the fingers that grip, N.
#[must_use]
pub fn force_range_n(percept: &Percept) -> (f64, f64) {
    percept.fingers[..FINGERS].iter().fold(
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

/// Vertical force of the object on all fingers that grip, base frame, N; negative while the object hangs.
#[must_use]
pub fn force_up_n(percept: &Percept, context: &Context<'_>) -> f64 {
    percept.fingers[..FINGERS]
        .iter()
        .zip(context.base_from_tip)
        .map(|(finger, base_from_tip)| (base_from_tip * finger.force_tip_n).z)
        .sum()
}
