//! Module 3, force limit (paper II.b (1)): "if grasping force exceeds threshold of maximum grasping
//! force F_2, grasping force enhancement is immediately stopped to prevent crushing the object (F_n
//! > F_2)".
//!
//! The compared force is the larger of tactile and joint-estimated force. Above `relieve_at`·F_2 of
//! both, the fingers open slowly and the hand waits; above F_2 if the goal sets the force limit. If
//! the grip closes without the force that belongs to its opening, it stops closing
//! ([`Drift`](crate::held_object::Drift)). An object that slips on every side at F_2 is refused.

use super::{Context, Module, Proposal, Verdict};
use crate::filter::{Dwell, low_pass};
use crate::perception::Percept;
use crate::thresholds::ForceLimitSource;
use robot_model::PerSide;
use shm_schemas::ModuleId;

/// Share of F_2 that deactivates the module (design choice: wider than the force noise).
pub(crate) const RELEASE_SHARE: f64 = 0.97;
/// Time constant of gross slip, s (design choice: the reading scatters by 3 % between frames).
const GROSS_FILTER_S: f64 = 0.1;

#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct ForceLimit {
    active: bool,
    /// Low-passed smallest momentary utilisation of the sides.
    slip_utilisation: f64,
    /// Duration of gross slip at F_2.
    slipping_out: Dwell,
}

impl Module for ForceLimit {
    const ID: ModuleId = ModuleId::FORCE_LIMIT;

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let settings = &context.settings.grasp;
        let (f2_n, drift) = (context.object.thresholds.f2_n, &context.object.drift);
        let (_, strongest_n) = percept.normal_range_n();
        let strongest_n = (strongest_n - drift.excess_n()) * context.hand.torque_over_tactile;
        self.active = exceeds_f2(strongest_n, self.active, f2_n);
        let relieve_at = match context.object.thresholds.source {
            ForceLimitSource::Goal => 1.0,
            ForceLimitSource::Hand | ForceLimitSource::Object => settings.relieve_at,
        };
        let ceiling_m_s = match self.active {
            true if strongest_n > relieve_at * f2_n * context.hand.tactile_over_torque => {
                -settings.relieve_m_s
            }
            true => 0.0,
            false => f64::INFINITY,
        };
        let ceiling_m_s = if drift.stops_closing {
            ceiling_m_s.min(0.0)
        } else {
            ceiling_m_s
        };
        let slides = self.is_slipping_out(percept, context);
        let thresholds = &context.object.thresholds;
        Proposal {
            active: self.active || drift.stops_closing,
            closing_ceiling_m_s: PerSide::repeat(ceiling_m_s),
            // The motion of the hand may raise the force, for example onto a support.
            carry_ceiling: if ceiling_m_s < 0.0 { 0.0 } else { 1.0 },
            verdict: if slides {
                Verdict::Refuse(thresholds.refusal(strongest_n, Self::ID))
            } else {
                Verdict::None
            },
            ..Proposal::default()
        }
    }
}

/// Returns whether the force exceeds F_2, with hysteresis.
pub(super) fn exceeds_f2(strongest_n: f64, exceeded: bool, f2_n: f64) -> bool {
    strongest_n > if exceeded { RELEASE_SHARE * f2_n } else { f2_n }
}

impl ForceLimit {
    /// Returns true after every side has slipped at F_2 for `too_heavy_s`, except with a verified
    /// grip.
    fn is_slipping_out(&mut self, percept: &Percept, context: &Context<'_>) -> bool {
        let settings = &context.settings.grasp;
        let least = percept
            .sides
            .iter()
            .map(|f| f.utilisation_now)
            .fold(f64::INFINITY, f64::min);
        self.slip_utilisation =
            low_pass(self.slip_utilisation, least, context.step_s, GROSS_FILTER_S);
        let sliding = self.active
            && !context.object.load_is_held
            && self.slip_utilisation > settings.too_heavy_gross;
        self.slipping_out.update(sliding, context.step_s);
        self.slipping_out.seconds() > settings.too_heavy_s
    }
}
