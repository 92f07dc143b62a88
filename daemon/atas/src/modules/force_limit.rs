//! Module 3, force limit (paper II.b (1)): "if grasping force exceeds threshold of maximum grasping force F_2, grasping
//! force enhancement is immediately stopped to prevent crushing the object (F_n > F_2)".
//!
//! Above `relieve_at`·F_2 it opens slowly. An object that slips on every finger although they press with F_2, or that
//! was carried some way while doing so, needs more force than its hardness allows: the module refuses it.

use super::{Context, Module, Proposal, Verdict, force_range_n};
use crate::perception::Percept;
use crate::settings::Grasp;
use robot_model::FINGERS;
use shm_schemas::{Cause, ModuleId, Reason};

/// Share of F_2 below which the module becomes inactive again (ours: wider than the force noise, so it does not flicker).
const RELEASE_SHARE: f64 = 0.97;

/// What the module remembers.
#[derive(Clone, Debug, Default)]
pub(super) struct ForceLimit {
    active: bool,
    /// How long the object has slipped at F_2, s.
    slipping_s: f64,
    /// How far the hand had carried when the force reached F_2, m.
    limited_since_m: Option<f64>,
}

impl Module for ForceLimit {
    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let settings = &context.settings.grasp;
        let f2_n = context.thresholds.f2_n;
        let (_, strongest_n) = force_range_n(percept);
        let active = strongest_n > if self.active { RELEASE_SHARE * f2_n } else { f2_n };
        self.active = active;
        let ceiling_m_s = match active {
            true if strongest_n > settings.relieve_at * f2_n => -settings.relieve_m_s,
            true => 0.0,
            false => f64::INFINITY,
        };
        Proposal {
            active,
            closing_ceiling_m_s: [ceiling_m_s; FINGERS],
            verdict: self.judge(
                active && slips_everywhere(percept, settings),
                strongest_n,
                context,
            ),
            ..Proposal::default()
        }
    }
}

impl ForceLimit {
    fn judge(&mut self, slips_at_limit: bool, strongest_n: f64, context: &Context<'_>) -> Verdict {
        let settings = &context.settings.grasp;
        let f2_n = context.thresholds.f2_n;
        if slips_at_limit {
            self.slipping_s += context.step_s;
        } else {
            self.slipping_s = (self.slipping_s - context.step_s).max(0.0);
        }
        let since_m = if slips_at_limit {
            *self.limited_since_m.get_or_insert(context.carried_m)
        } else {
            context.carried_m
        };
        if !slips_at_limit && self.slipping_s == 0.0 {
            self.limited_since_m = None;
        }
        let too_long = self.slipping_s > settings.too_heavy_s;
        let too_far = slips_at_limit && context.carried_m - since_m > settings.too_heavy_travel_m;
        if too_long || too_far {
            Verdict::Refuse(
                Reason::limit(Cause::TOO_HEAVY, strongest_n, f2_n).by(ModuleId::FORCE_LIMIT),
            )
        } else {
            Verdict::None
        }
    }
}

fn slips_everywhere(percept: &Percept, settings: &Grasp) -> bool {
    percept.fingers[..FINGERS].iter().all(|finger| {
        finger.utilisation_now > settings.slip_gross
            && finger.utilisation > settings.too_heavy_utilisation
    })
}
