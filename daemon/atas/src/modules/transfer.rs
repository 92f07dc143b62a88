//! Module 0' (paper II.b (3)): "conveys and sets an object down to a specified plane position after
//! it picks the object up from a specified position. Laying down is terminated by the activation of
//! module 4."
//!
//! Conveys along the step's path at a safe height. A lowering step then moves straight down at
//! `place.lower_m_s` towards a support of unknown height, until Module 4 ends the step or its depth
//! limit is reached.

use super::release_placed::lowering_speed_m_s;
use super::{Context, Module, PoseCommand, Proposal, Roles};
use crate::limits::LOWERING_ACCELERATION_M_S2;
use crate::perception::Percept;
use nalgebra::Vector3;
use shm_schemas::ModuleId;

#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Transfer {
    /// Path time, s.
    path_s: f64,
    /// Lowering speed, m/s.
    lowering_m_s: f64,
    /// Lowered distance, m.
    lowered_m: f64,
}

impl Module for Transfer {
    const ID: ModuleId = ModuleId::TRANSFER;
    const ROLES: Roles = Roles {
        moves_hand: true,
        resets_each_step: true,
        ..Roles::NONE
    };

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let scaled_s = context.step_s * context.hand.carry_scale;
        self.path_s = (self.path_s + scaled_s).max(0.0);
        let conveyed = self.path_s >= context.path.duration_s();
        let depth_max_m = context.lowering_m.unwrap_or(0.0);
        if conveyed && self.lowered_m < depth_max_m {
            let faster_m_s = self.lowering_m_s + LOWERING_ACCELERATION_M_S2 * scaled_s.max(0.0);
            self.lowering_m_s = faster_m_s.min(lowering_speed_m_s(percept, context));
            self.lowered_m = (self.lowered_m + self.lowering_m_s * scaled_s).max(0.0);
        }
        let mut frame = context.path.pose_at(self.path_s);
        frame.centre_m -= Vector3::z() * self.lowered_m;
        let arrived = conveyed && self.lowered_m >= depth_max_m;
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

impl Transfer {
    /// Restarts from rest.
    pub(super) fn stop(&mut self) {
        self.lowering_m_s = 0.0;
    }
}
