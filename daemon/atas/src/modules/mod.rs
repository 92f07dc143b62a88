//! Program modules of the paper (section II, Fig. 4): one file each, evaluated in parallel without
//! priority.
//!
//! Inputs: the tactile state of the hand ([`crate::perception::Percept`]) and its [`Context`].
//! Output: one [`Proposal`] per module. Every module decides from sensor information whether it is
//! active. No module depends on another, and the order of the list has no effect:
//! [`crate::arbitration`] merges the proposals by order-independent rules. This distinguishes ATAS
//! from subsumption.
//!
//! A new module needs a file here, its name in [`ModuleId`](shm_schemas::ModuleId), an entry in the
//! list below, and a task that selects it. `CONTRIBUTING.md` shows an example.
//!
//! | file | module | paper |
//! |---|---|---|
//! | `first_touch` | 1: closes until F_n > F_1 | II.b (1) |
//! | `slip` | 2: increases force while slipping, dF_t > dr | II.b (1) |
//! | `force_limit` | 3: stops closing above F_2 | II.b (1) |
//! | `relax` | reduces force that friction does not need | – |
//! | `lift_verification` | pulls back during a lift to detect whether the object is suspended | – |
//! | `probe` | measures stiffness for 100 ms after first touch, then refines it | II.b (1) |
//! | `contact_guard` | turns the hand back on unexpected contact | – |
//! | `carry` | moves the hand along the path of the step | II.b (1), (3) |
//! | `trajectory` | 0: square trajectory, adapted to contact | II.b (2) |
//! | `terminate_screw` | 4: ends screwing at dF_t > 1.4 dF_max | II.b (2) |
//! | `transfer` | 0': conveys and sets down | II.b (3) |
//! | `release_placed` | 4: ends placing on upward force | II.b (3) |
//! | `teleop` | tracks the targets that a client streams | – |
//! | `behaviour_table` | sets closing and path speed from the task's table | III |
//! | `slip_reaction` | comparison baseline; in no built-in task | Romano et al. 2011 |

mod behaviour_table;
mod carry;
mod contact_guard;
mod first_touch;
mod force_limit;
mod lift_verification;
mod list;
mod load_growth;
mod probe;
mod proposal;
mod relax;
mod release_placed;
mod selection;
mod slip;
mod slip_reaction;
mod teleop;
mod terminate_screw;
mod trajectory;
mod transfer;

pub(crate) use force_limit::RELEASE_SHARE;
pub use proposal::{Context, Module, PoseCommand, Proposal, Roles, Verdict};
pub use selection::Selection;

list::modules! {
    carry::Carry,
    first_touch::FirstTouch,
    probe::Probe,
    slip::Slip,
    force_limit::ForceLimit,
    relax::Relax,
    transfer::Transfer,
    release_placed::ReleasePlaced,
    trajectory::Trajectory,
    terminate_screw::TerminateScrew,
    contact_guard::ContactGuard,
    lift_verification::LiftVerification,
    slip_reaction::SlipReaction,
    teleop::Teleop,
    behaviour_table::BehaviourTable,
}

impl Modules {
    /// Restarts motion from rest after the hand was stopped.
    pub fn stop(&mut self) {
        self.teleop = teleop::Teleop::default();
        self.trajectory.stop();
        self.transfer.stop();
        self.release_placed.stop();
    }

    /// Resets all modules after the object is released, except teleoperation.
    pub fn release_object(&mut self) {
        let teleop = core::mem::take(&mut self.teleop);
        self.reset();
        self.teleop = teleop;
    }
}
