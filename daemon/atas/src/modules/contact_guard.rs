//! Contact guard (not in the paper): turns the hand back when a fingertip touches something during
//! free approach. Contacts elsewhere on the arm or hand go undetected.

use super::{Context, Module, Proposal, Verdict};
use crate::perception::Percept;
use shm_schemas::{ModuleId, Reason};

/// Multiple of the touch threshold that turns the hand back (design choice: lower values let noise
/// end a goal).
const TOUCH_FACTOR: f64 = 2.0;

/// Stateless module.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct ContactGuard;

impl Module for ContactGuard {
    const ID: ModuleId = ModuleId::CONTACT_GUARD;

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let limit_n = TOUCH_FACTOR * context.settings.perception.touch_on_n;
        let touching = percept
            .fingertips
            .iter()
            .position(|finger| finger.in_contact && finger.normal_n > limit_n);
        let Some(fingertip) = touching else {
            return Proposal::default();
        };
        Proposal {
            active: true,
            carry_ceiling: 0.0,
            verdict: Verdict::Refuse(Reason::Obstructed {
                fingertip,
                force_n: percept.fingertips[fingertip].normal_n,
                limit_n,
                module: Self::ID,
            }),
            ..Proposal::default()
        }
    }
}
