//! Carry: moves the hand along the path of the present step, at the speed that the other modules
//! tolerate.
//!
//! The paper's robot lifts, conveys and lowers without naming a module for it. As a proposal, this
//! motion can be slowed by slip.

use super::{Context, Module, PoseCommand, Proposal, Roles};
use crate::perception::Percept;
use shm_schemas::ModuleId;

/// Position of the hand along its path, s of path time.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Carry {
    path_s: f64,
}

impl Module for Carry {
    const ID: ModuleId = ModuleId::CARRY;
    const ROLES: Roles = Roles {
        moves_hand: true,
        resets_each_step: true,
        ..Roles::NONE
    };

    fn evaluate(&mut self, _percept: &Percept, context: &Context<'_>) -> Proposal {
        self.path_s = (self.path_s + context.step_s * context.hand.carry_scale).max(0.0);
        let arrived = self.path_s >= context.path.duration_s();
        let frame = context.path.pose_at(self.path_s);
        Proposal {
            active: !arrived,
            pose: Some(PoseCommand {
                pose: frame,
                with_fingers: context.path.moves_fingers(),
                arrived,
            }),
            ..Proposal::default()
        }
    }
}
