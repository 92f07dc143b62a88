//! The program modules of the paper (section II, Fig. 4): one file each, in parallel, without priority.
//!
//! In: what the hand feels ([`crate::perception::Percept`]) and what it is about ([`Context`]). Out: one [`Proposal`] per module. Every
//! module says from sensor information whether it is active and what it would do; none knows of another, and the order
//! of the list means nothing ([`crate::arbitration`] merges by rules that do not depend on it). That is what separates
//! ATAS from subsumption.
//!
//! A new module is a file here, its name in [`ModuleId`](shm_schemas::ModuleId), its line in the list below, and the task
//! that has it: `CONTRIBUTING.md` shows one.
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
//! | `follow` | leads the hand after a client's targets | ours |
//! | `behaviour_table` | fingers and hand as the row of the task's table says | III |
//! | `slip_reaction` | a baseline to compare with; in no built-in task | Romano et al. 2011 |

mod behaviour_table;
mod carry;
mod contact_guard;
mod fall;
mod first_touch;
mod follow;
mod force_limit;
mod list;
mod load_test;
mod probe;
mod proposal;
mod relax;
mod release_placed;
mod selection;
mod slip;
mod slip_reaction;
mod terminate_screw;
mod trajectory;
mod transfer;
mod vain;

pub(crate) use force_limit::RELEASE_SHARE;
pub use proposal::{
    Context, Finding, Module, PoseCommand, Proposal, Roles, Verdict, force_range_n, force_up_n,
    load_n,
};
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
    load_test::LoadTest,
    slip_reaction::SlipReaction,
    follow::Follow,
    behaviour_table::BehaviourTable,
}

impl Modules {
    /// The hand was stopped: what moves it begins from rest.
    pub fn halt(&mut self) {
        self.follow = follow::Follow::default();
        self.trajectory.halt();
        self.transfer.halt();
        self.release_placed.halt();
    }

    /// Forgets the present object; what leads the hand goes on.
    pub fn let_go(&mut self) {
        let follow = core::mem::take(&mut self.follow);
        self.reset();
        self.follow = follow;
    }
}
