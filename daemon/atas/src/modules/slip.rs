//! Module 2, slip (paper II.b (1)): "if partial slippage occurs, grasping force increasing behavior continues, and
//! otherwise the behavior is stopped (slippage is estimated by whether tangential force increment dF_t exceeds
//! threshold dr)".
//!
//! The bare rule dF_t > dr fails: smooth sliding has dF_t = 0, and pressing on a sliding contact only just sustains
//! itself. Partial slip shows in the distribution of forces instead, as the friction utilisation S. The module is
//! active while any finger
//!   (a) uses more than `slip_on` of its friction, until less than `slip_off`,
//!   (b) slips grossly, or
//!   (c) uses more than `slip_loading` while its load grows, dF_t > dr: the paper's rule, gated by S.
//! It stays active for `slip_latch_s` after the last cause. While pressing can still help it slows the hand down.

use super::{Context, Module, Proposal, Roles, force_range_n};
use crate::perception::{FingerPercept, Percept};
use crate::settings::Grasp;
use robot_model::FINGERS;
use shm_schemas::ModuleId;

/// What the module remembers.
#[derive(Clone, Debug, Default)]
pub(super) struct Slip {
    /// Per finger, whether cause (a) holds.
    slipping: [bool; FINGERS],
    /// Time until the latch opens, s.
    latch_s: f64,
}

impl Module for Slip {
    const ID: ModuleId = ModuleId::SLIP;
    const ROLES: Roles = Roles {
        closes_fingers: true,
        ..Roles::NONE
    };

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let settings = &context.settings.grasp;
        let mut cause = false;
        for (slipping, finger) in self.slipping.iter_mut().zip(&percept.fingers) {
            *slipping = finger.utilisation
                > if *slipping {
                    settings.slip_off
                } else {
                    settings.slip_on
                };
            cause |= *slipping || slips_grossly(finger, settings) || is_loading(finger, settings);
        }
        self.latch_s = if cause {
            settings.slip_latch_s
        } else {
            self.latch_s - context.step_s
        };
        let active = cause || self.latch_s > 0.0;
        let (_, strongest_n) = force_range_n(percept);
        // Setting down ends the slipping sooner than waiting would.
        let helps = strongest_n < context.thresholds.f2_n && context.lowering_m.is_none();
        Proposal {
            active,
            closing_m_s: [if active { settings.enhance_m_s } else { 0.0 }; FINGERS],
            carry_ceiling: if active && helps {
                settings.slip_carry_scale
            } else {
                1.0
            },
            ..Proposal::default()
        }
    }
}

fn slips_grossly(finger: &FingerPercept, settings: &Grasp) -> bool {
    finger.gross_slip_s > settings.slip_gross_s
}

fn is_loading(finger: &FingerPercept, settings: &Grasp) -> bool {
    finger.increment_n > settings.dr_n && finger.utilisation > settings.slip_loading
}
