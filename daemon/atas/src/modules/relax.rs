//! Relax (ours, not in the paper): lets go of force that friction does not need.
//!
//! The paper's grasp ends with a "suitable normal force that generated maximum static friction force"; modules 1 to 3
//! alone can only ever add force. While the load is steady (dF_t < dr) and every finger uses less than `relax_below` of
//! its friction, the fingers open slowly, the more slowly the nearer they are to it, and never below F_1.

use super::{Context, Module, Proposal, force_range_n};
use crate::perception::Percept;
use robot_model::FINGERS;

/// Multiple of F_1 down to which the module relaxes: a little above, so that Module 1 need not answer (ours).
const F1_MARGIN: f64 = 1.1;

/// The module has no memory: what the fingers feel decides.
#[derive(Clone, Debug, Default)]
pub(super) struct Relax;

impl Module for Relax {
    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let settings = &context.settings.grasp;
        let fingers = &percept.fingers[..FINGERS];
        let (weakest_n, _) = force_range_n(percept);
        let steady = fingers
            .iter()
            .all(|f| f.increment_n < settings.dr_n && f.gross_slip_s == 0.0);
        let known = fingers.iter().all(|f| f.utilisation > 0.0);
        let utilisation = fingers.iter().fold(0.0, |most: f64, f| {
            if f.utilisation > most {
                f.utilisation
            } else {
                most
            }
        });
        let spare = 1.0 - utilisation / settings.relax_below;
        let active =
            steady && known && spare > 0.0 && weakest_n > F1_MARGIN * context.thresholds.f1_n;
        let opening_m_s = if active {
            settings.relax_m_s * spare
        } else {
            0.0
        };
        Proposal {
            active,
            closing_m_s: [-opening_m_s; FINGERS],
            ..Proposal::default()
        }
    }
}
