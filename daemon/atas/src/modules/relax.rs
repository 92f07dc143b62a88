//! Relax (ours, not in the paper): lets go of force that friction does not need.
//!
//! The paper's grasp ends with a "suitable normal force that generated maximum static friction force"; modules 1 to 3
//! alone can only ever add force. While the load is steady (dF_t < dr) and every finger uses less than `relax_below` of
//! its friction, the fingers open slowly, the more slowly the nearer they are to it, and never below the least force of
//! a grip.

use super::{Context, Module, Proposal, force_range_n};
use crate::limits::FRICTION_FLOOR;
use crate::perception::{FingerPercept, Percept};
use robot_model::FINGERS;
use shm_schemas::ModuleId;

/// Multiple of the least force down to which the module relaxes: a little above, so that Module 1 need not answer (ours).
const LEAST_MARGIN: f64 = 1.1;
/// Spare utilisation from which on it opens at full speed (ours: a tenth of the friction is a tenth of the force).
const SPARE_FULL: f64 = 0.1;
/// How many standard deviations noise may have added to the remembered friction (ours): it is the highest of many
/// readings, each of the elements that read highest.
const DOUBT: f64 = 2.5;
/// Time constant over which the utilisation is judged, s (ours: it only ever opens, so it must not follow single readings).
const FILTER_S: f64 = 0.1;

/// What the module remembers.
#[derive(Clone, Debug, Default)]
pub(super) struct Relax {
    /// Low-passed utilisation of the finger that uses most of its friction; `None` while it is unknown.
    utilisation: Option<f64>,
}

impl Module for Relax {
    const ID: ModuleId = ModuleId::RELAX;

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let settings = &context.settings.grasp;
        let fingers = &percept.fingers[..FINGERS];
        let steady = fingers
            .iter()
            .all(|f| f.increment_n < settings.dr_n && f.gross_slip_s == 0.0);
        let (weakest_n, _) = force_range_n(percept);
        let firm = weakest_n > LEAST_MARGIN * context.least_n;
        let spare = self
            .watch(percept, context.step_s)
            .map_or(0.0, |utilisation| 1.0 - utilisation / settings.relax_below);
        let active = steady && firm && spare > 0.0;
        let opening_m_s = if active {
            settings.relax_m_s * (spare / SPARE_FULL).min(1.0)
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

impl Relax {
    /// The low-passed utilisation, while every finger knows its own.
    fn watch(&mut self, percept: &Percept, step_s: f64) -> Option<f64> {
        let fingers = &percept.fingers[..FINGERS];
        let known = fingers.iter().all(|f| f.utilisation > 0.0);
        let most = fingers
            .iter()
            .map(doubtful_utilisation)
            .fold(0.0, |most, utilisation| {
                if utilisation > most {
                    utilisation
                } else {
                    most
                }
            });
        self.utilisation = known.then(|| {
            let before = self.utilisation.unwrap_or(most);
            before + (most - before) * step_s / (FILTER_S + step_s)
        });
        self.utilisation
    }
}

/// Utilisation if the friction is as much less than remembered as noise may have added to it.
fn doubtful_utilisation(finger: &FingerPercept) -> f64 {
    let friction = finger.friction.max(FRICTION_FLOOR);
    let least = (friction - DOUBT * finger.friction_error).max(FRICTION_FLOOR);
    finger.utilisation * friction / least
}
