//! Module 2, slip (paper II.b (1)): "if partial slippage occurs, grasping force increasing behavior continues, and
//! otherwise the behavior is stopped (slippage is estimated by whether tangential force increment dF_t exceeds
//! threshold dr)".
//!
//! The bare rule dF_t > dr fails: smooth sliding has dF_t = 0, and pressing on a sliding contact only just sustains
//! itself. Partial slip shows in the distribution of forces instead, as the friction utilisation S. The module is
//! active while any finger
//!   (a) uses more than `slip_on` of its friction, until less than `slip_off`,
//!   (b) slips grossly, or
//!   (c) carries a load that grew since the module last ended (F_t/F_n up by `slip_growth`, F_t by `slip_growth_n`).
//! It stays active for `slip_latch_s` after the last cause. While pressing can still help it slows the hand down.

use super::{Context, Module, Proposal, force_range_n};
use crate::perception::{FingerPercept, Percept};
use crate::settings::Grasp;
use robot_model::FINGERS;

/// Smallest normal force that F_t is divided by, N.
const NORMAL_MIN_N: f64 = 0.01;

/// What the module remembers.
#[derive(Clone, Debug, Default)]
pub(super) struct Slip {
    fingers: [FingerMemory; FINGERS],
    /// Time until the latch opens, s.
    latch_s: f64,
}

/// What it remembers of one finger.
#[derive(Clone, Copy, Debug, Default)]
struct FingerMemory {
    /// Causes (a) and (b), with hysteresis.
    slipping: bool,
    /// Cause (c).
    loaded: bool,
    /// F_t/F_n and F_t, N, when the module last ended.
    settled: Option<(f64, f64)>,
}

impl Module for Slip {
    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let settings = &context.settings.grasp;
        let mut cause = false;
        for (memory, finger) in self.fingers.iter_mut().zip(&percept.fingers) {
            cause |= memory.update(finger, settings);
        }
        let active = self.latch(cause, percept, context);
        let (_, strongest_n) = force_range_n(percept);
        let helps = strongest_n < context.thresholds.f2_n;
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

impl Slip {
    fn latch(&mut self, cause: bool, percept: &Percept, context: &Context<'_>) -> bool {
        if cause {
            self.latch_s = context.settings.grasp.slip_latch_s;
            return true;
        }
        let was_active = self.latch_s > 0.0;
        self.latch_s -= context.step_s;
        if was_active && self.latch_s <= 0.0 {
            for (memory, finger) in self.fingers.iter_mut().zip(&percept.fingers) {
                memory.settle(finger);
            }
        }
        self.latch_s > 0.0
    }
}

impl FingerMemory {
    fn update(&mut self, finger: &FingerPercept, settings: &Grasp) -> bool {
        let gross = finger.gross_slip_s > settings.slip_gross_s;
        if finger.utilisation > settings.slip_on || gross {
            self.slipping = true;
        } else if finger.utilisation < settings.slip_off {
            self.slipping = false;
        }
        if let Some((ratio, tangential_n)) = self.settled {
            let now = ratio_of(finger);
            if now > settings.slip_growth * ratio
                && finger.tangential_n > tangential_n + settings.slip_growth_n
            {
                self.loaded = true;
            } else if now < ratio {
                self.loaded = false;
            }
        }
        self.slipping || self.loaded
    }

    fn settle(&mut self, finger: &FingerPercept) {
        self.settled = Some((ratio_of(finger), finger.tangential_n));
        self.loaded = false;
    }
}

fn ratio_of(finger: &FingerPercept) -> f64 {
    let normal_n = if finger.normal_n > NORMAL_MIN_N {
        finger.normal_n
    } else {
        NORMAL_MIN_N
    };
    finger.tangential_n / normal_n
}
