//! Contact guard (ours): the hand that moves freely towards an object expects to touch nothing. What it touches all the same
//! turns it back the way it came, before the arm pushes the thing over.
//!
//! Only fingertips feel: what an arm or the back of a finger hits is not noticed.

use super::{Context, Module, Proposal, Verdict};
use crate::perception::Percept;
use shm_schemas::{Cause, ModuleId, Reason};

/// Multiple of the touch threshold that turns the hand back (ours): noise that a slow approach shrugs off must not end a goal.
const TOUCH_FACTOR: f64 = 2.0;

/// The module has no memory: a touch is a touch.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct ContactGuard;

impl Module for ContactGuard {
    const ID: ModuleId = ModuleId::CONTACT_GUARD;

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let limit_n = TOUCH_FACTOR * context.settings.perception.touch_on_n;
        let touching = percept
            .fingers
            .iter()
            .position(|finger| finger.in_contact && finger.normal_n > limit_n);
        let Some(index) = touching else {
            return Proposal::default();
        };
        let reason = Reason::limit(Cause::OBSTRUCTED, percept.fingers[index].normal_n, limit_n);
        Proposal {
            active: true,
            carry_ceiling: 0.0,
            verdict: Verdict::Refuse(reason.about(index).by(ModuleId::CONTACT_GUARD)),
            ..Proposal::default()
        }
    }
}
