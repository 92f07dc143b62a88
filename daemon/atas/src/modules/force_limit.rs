//! Module 3, force limit (paper II.b (1)): "if grasping force exceeds threshold of maximum grasping force F_2, grasping
//! force enhancement is immediately stopped to prevent crushing the object (F_n > F_2)".
//!
//! Above `relieve_at`·F_2 it opens slowly. What slips on every finger although they press with F_2 may be too heavy,
//! or it may hang safely close to the limit: the forces look alike. So the module lets the hand travel on until
//! anything that can be lifted has left its support, and then tugs back a little. An object that hangs keeps its load;
//! one that still stands gives it back to its support, and is refused.

use super::{Context, Module, Proposal, Verdict, force_range_n};
use crate::perception::Percept;
use crate::settings::Grasp;
use robot_model::FINGERS;
use shm_schemas::{Cause, ModuleId, Reason};

/// Share of F_2 below which the module becomes inactive again (ours: wider than the force noise, so it does not flicker).
const RELEASE_SHARE: f64 = 0.97;
/// How far the tug goes back, m (ours: beyond what the rim of a patch stretches, well below what was lifted before).
const TUG_M: f64 = 0.0004;
/// Share of the load that an object must keep during the tug to count as hanging (ours).
const HANGING_SHARE: f64 = 0.6;
/// Time constant over which gross slip is judged, s (ours: its reading scatters by 3 % from frame to frame).
const GROSS_FILTER_S: f64 = 0.1;

/// What the module remembers.
#[derive(Clone, Debug, Default)]
pub(super) struct ForceLimit {
    active: bool,
    suspicion: Suspicion,
    /// Low-passed momentary utilisation of the finger that slips least.
    gross: f64,
    /// How long the object has slipped grossly at F_2, s.
    gross_s: f64,
}

/// Whether the object may be too heavy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Suspicion {
    /// It does not slip at F_2.
    #[default]
    None,
    /// It has slipped at F_2 since the hand had carried this far, m.
    Slipping(f64),
    /// The hand tugs back from here, m; loads before and least load since, N.
    Tugging {
        from_m: f64,
        load_n: f64,
        least_n: f64,
    },
    /// It hangs.
    Cleared,
}

impl Module for ForceLimit {
    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let settings = &context.settings.grasp;
        let f2_n = context.thresholds.f2_n;
        let (_, strongest_n) = force_range_n(percept);
        self.active = strongest_n
            > if self.active {
                RELEASE_SHARE * f2_n
            } else {
                f2_n
            };
        let ceiling_m_s = match self.active {
            true if strongest_n > settings.relieve_at * f2_n => -settings.relieve_m_s,
            true => 0.0,
            false => f64::INFINITY,
        };
        let too_heavy = self.stands(percept, context) || self.slides(percept, context);
        let reason = Reason::limit(Cause::TOO_HEAVY, strongest_n, f2_n).by(ModuleId::FORCE_LIMIT);
        Proposal {
            active: self.active,
            closing_ceiling_m_s: [ceiling_m_s; FINGERS],
            carry_ceiling: if matches!(self.suspicion, Suspicion::Tugging { .. }) {
                -1.0
            } else {
                1.0
            },
            verdict: if too_heavy {
                Verdict::Refuse(reason)
            } else {
                Verdict::None
            },
            ..Proposal::default()
        }
    }
}

impl ForceLimit {
    /// Follows the suspicion; true when the tug found that the object still stands on its support.
    fn stands(&mut self, percept: &Percept, context: &Context<'_>) -> bool {
        let settings = &context.settings.grasp;
        let slips = self.active && slips_everywhere(percept, settings);
        let (carried_m, load_n) = (context.carried_m, load_n(percept));
        self.suspicion = match self.suspicion {
            Suspicion::None if slips => Suspicion::Slipping(carried_m),
            Suspicion::Slipping(from_m)
                if slips && carried_m - from_m > settings.too_heavy_travel_m =>
            {
                Suspicion::Tugging {
                    from_m: carried_m,
                    load_n,
                    least_n: load_n,
                }
            }
            Suspicion::Tugging {
                from_m,
                load_n: before_n,
                least_n,
            } if from_m - carried_m > TUG_M => {
                self.suspicion = Suspicion::Cleared;
                return least_n < HANGING_SHARE * before_n;
            }
            Suspicion::Tugging {
                from_m,
                load_n: before_n,
                least_n,
            } => Suspicion::Tugging {
                from_m,
                load_n: before_n,
                least_n: if load_n < least_n { load_n } else { least_n },
            },
            unchanged => unchanged,
        };
        false
    }

    /// True when every finger has slid at F_2 for so long that the object is on its way out of the hand.
    fn slides(&mut self, percept: &Percept, context: &Context<'_>) -> bool {
        let settings = &context.settings.grasp;
        let least = percept.fingers[..FINGERS]
            .iter()
            .map(|f| f.utilisation_now)
            .fold(f64::INFINITY, f64::min);
        self.gross += (least - self.gross) * context.step_s / (GROSS_FILTER_S + context.step_s);
        let sliding = self.active && self.gross > settings.too_heavy_gross;
        self.gross_s = if sliding {
            self.gross_s + context.step_s
        } else {
            0.0
        };
        self.gross_s > settings.too_heavy_s
    }
}

fn slips_everywhere(percept: &Percept, settings: &Grasp) -> bool {
    percept.fingers[..FINGERS]
        .iter()
        .all(|finger| finger.utilisation > settings.too_heavy_utilisation)
}

/// Tangential force that all fingers carry, N.
fn load_n(percept: &Percept) -> f64 {
    percept.fingers[..FINGERS]
        .iter()
        .map(|f| f.tangential_n)
        .sum()
}
