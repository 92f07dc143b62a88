//! Module 1, first touch (paper II.b (1)): "if the grasping force reaches threshold of minimum
//! grasping force F_1 when it first touches the object, the grasping force enhancement behavior is
//! stopped (F_n > F_1)".
//!
//! Each side closes at the approach speed (paper: 2 mm/s), stops at its own first touch and waits
//! for the other. Then both close until the weaker side exceeds F_1. For an object that is already
//! carried, the module only maintains contact. It is active while it closes.

use super::{Context, Module, Proposal, Roles};
use crate::perception::Percept;
use robot_model::PerSide;
use shm_schemas::ModuleId;

/// Stateless module.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct FirstTouch;

impl Module for FirstTouch {
    const ID: ModuleId = ModuleId::FIRST_TOUCH;
    const ROLES: Roles = Roles {
        closes_fingers: true,
        ..Roles::NONE
    };

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let (weakest_n, _) = percept.normal_range_n();
        let enhance = if context.object.all_touched {
            PerSide::repeat(weakest_n <= context.object.min_force_n)
        } else {
            percept.sides.each_ref().map(|side| !side.in_contact)
        };
        let speed_m_s = context.settings.grasp.approach_m_s;
        Proposal {
            active: enhance.iter().any(|enhance| *enhance),
            closing_m_s: enhance.map(|enhance| if enhance { speed_m_s } else { 0.0 }),
            ..Proposal::default()
        }
    }
}
