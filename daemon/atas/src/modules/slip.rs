//! Module 2, slip (paper II.b (1)): "if partial slippage occurs, grasping force increasing behavior continues, and
//! otherwise the behavior is stopped (slippage is estimated by whether tangential force increment dF_t exceeds
//! threshold dr)".
//!
//! The bare rule dF_t > dr fails: smooth sliding has dF_t = 0, and pressing on a sliding contact only just sustains
//! itself. Partial slip shows in the distribution of forces instead, as the friction utilisation S. The module is
//! active while any finger
//!   (a) uses more than `slip_on` of its friction, until less than `slip_off` (in a hand that a client leads, 0.84 of both),
//!   (b) slips grossly,
//!   (c) uses more than `slip_loading` while its load grows, dF_t > dr: the paper's rule, gated by S where anything is known of friction,
//!   (d) carries half of the moment about the closing axis that friction could: what hangs beside its centre of mass turns in
//!       the hand before it slips out of it, or
//!   (e) while what hangs in the hand weighs less than just before: then it falls. This needs no friction coefficient.
//! While the load test tries how gently what hangs just above its support can be held, (a) and (c) say nothing: a slip costs
//! nothing there. In a grip as firm as the one that the test has proved, nothing that is read from the pattern of forces does, (a) to
//! (c): faces askew shear a patch alike all over, and a poor sensor reads a wrong friction, but what was tugged at has hung.
//!
//! Nor do they while pressing brings no load to what is lifted and has not been tested yet.
//!
//! It stays active for `slip_latch_s` after the last cause. While pressing can still help it slows the hand down.

use super::fall::Fall;
use super::vain::Vain;
use super::{Context, Finding, Module, Proposal, Roles, force_range_n, force_up_n};
use crate::perception::{FingerPercept, Percept};
use robot_model::VIRTUAL_FINGERS;
use shm_schemas::ModuleId;

/// Share of the moment that friction could carry at which an object is about to turn in the hand, and below which it is not
/// (ours: at 0.6 the first have turned by 10°).
const TORSION_ON: f64 = 0.5;
const TORSION_OFF: f64 = 0.45;
/// Momentary utilisation of what hangs at which its patch is sheared alike everywhere, and utilisation without which it is only
/// lightly loaded (ours).
const ALIKE: f64 = 0.935;
const ALIKE_ABOVE: f64 = 0.8;
/// How far aside the end of the way must be for a hand to be conveying, m (ours).
const CONVEYS_M: f64 = 0.001;
/// How long a load swings after the hand has changed its speed, s (ours).
const BRAKING_S: f64 = 0.15;
/// Multiple of the pressing speed while it falls (ours): it falls by millimetres otherwise.
const HURRY: f64 = 3.0;
/// Share of `slip_on` and `slip_off` at which a hand that a client leads presses harder (ours: what slides bears a tenth less than what
/// sticks, so S falls below `slip_on` once it does; and dragged around a curved face, elements that lean into the way read up to a fifth
/// more friction than there is. A grasp finds either out by its load test; a client moves as it likes. It costs a hundredth of over-grip).
const LED_SHARE: f64 = 0.84;
/// How far the hand must have carried its object, so that nothing but the hand holds it, m (ours).
const HANGS_M: f64 = 0.001;
/// Share of the tangential force that a trembling hand changes within the window of dF_t, usually and at most (ours).
pub(super) const STEADY_SHARE: f64 = 0.06;
const TREMBLE_SHARE: f64 = 0.1;

/// What the module remembers.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Slip {
    /// Per finger, whether cause (a) holds.
    slipping: [bool; VIRTUAL_FINGERS],
    /// Per finger, whether cause (d) holds.
    turning: [bool; VIRTUAL_FINGERS],
    /// The load, while it hangs and is not being set down.
    fall: Fall,
    /// What pressing brings, while it is not yet known whether what is lifted hangs.
    vain: Vain,
    /// Time until the latch opens, s.
    latch_s: f64,
    /// Factor on the hand's speed a tick before, and time until what its change shook is over, s.
    carry_scale: f64,
    braking_s: f64,
}

impl Module for Slip {
    const ID: ModuleId = ModuleId::SLIP;
    const ROLES: Roles = Roles {
        closes_fingers: true,
        ..Roles::NONE
    };

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let settings = &context.settings.grasp;
        let down_n = -force_up_n(percept, context.base_from_tip);
        let brakes = self.brakes(context);
        let load_n = hangs(context).then_some(down_n);
        let falls = self.fall.follow(load_n, brakes, percept.step_s);
        let mut cause = falls;
        for (turning, finger) in self.turning.iter_mut().zip(&percept.fingers) {
            *turning = turns(finger, *turning, context);
            cause |= *turning;
        }
        let in_vain = self.press_in_vain(percept, down_n, context);
        for (slipping, finger) in self.slipping.iter_mut().zip(&percept.fingers) {
            *slipping = uses_up(finger, *slipping, context);
            let nears = *slipping || (!brakes && is_loading(finger, context));
            let slips = slips_grossly(finger, context) || (nears && !context.tries);
            cause |= slips && !context.proved && !in_vain;
        }
        self.latch_s = if cause {
            settings.slip_latch_s
        } else {
            self.latch_s - context.step_s
        };
        let active = cause || self.latch_s > 0.0;
        let (_, strongest_n) = force_range_n(percept);
        // Setting down ends the slipping sooner than waiting would. What is lifted off weighs the same at any speed: a hand
        // that brakes would only shake it.
        let loads = !hangs(context) || conveys(context);
        let helps = loads && strongest_n < context.thresholds.f2_n && context.lowering_m.is_none();
        let closing_m_s = match (active, falls) {
            (_, true) => HURRY * settings.enhance_m_s,
            (true, false) => settings.enhance_m_s,
            (false, false) => 0.0,
        };
        Proposal {
            active,
            closing_m_s: [closing_m_s; VIRTUAL_FINGERS],
            carry_ceiling: if active && helps {
                settings.slip_carry_scale
            } else {
                1.0
            },
            finding: Finding {
                slides: falls,
                ..Finding::default()
            },
            ..Proposal::default()
        }
    }
}

impl Slip {
    /// Whether what is lifted bears no more on the fingers although they press harder.
    fn press_in_vain(&mut self, percept: &Percept, down_n: f64, context: &Context<'_>) -> bool {
        let lifts = context.carried_m > 0.0 && !context.hangs;
        let normal_n: f64 = percept.virtual_fingers.iter().map(|f| f.normal_n).sum();
        self.vain
            .follow(lifts.then_some((normal_n, down_n)), percept.step_s)
    }

    /// Whether the hand that carries has just changed its speed: that shakes its load.
    fn brakes(&mut self, context: &Context<'_>) -> bool {
        let before = core::mem::replace(&mut self.carry_scale, context.carry_scale);
        self.braking_s = if before == context.carry_scale {
            self.braking_s - context.step_s
        } else {
            BRAKING_S
        };
        hangs(context) && self.braking_s > 0.0
    }
}

/// Whether the hand alone carries, and is not about to set down.
fn hangs(context: &Context<'_>) -> bool {
    context.hangs && context.carried_m > HANGS_M && context.lowering_m.is_none()
}

/// Whether the hand is on its way to another place, where its own motion may shake the grip loose.
fn conveys(context: &Context<'_>) -> bool {
    let ahead_m = context.path.end().centre_m - context.frame.centre_m;
    ahead_m.xy().norm() > CONVEYS_M
}

/// Whether a finger uses up its friction, with hysteresis; of a hand that is led, sooner.
pub(super) fn uses_up(finger: &FingerPercept, used_up: bool, context: &Context<'_>) -> bool {
    let settings = &context.settings.grasp;
    let share = if context.lead.is_some() {
        LED_SHARE
    } else {
        1.0
    };
    let limit = if used_up {
        settings.slip_off
    } else {
        settings.slip_on
    };
    finger.utilisation > share * limit
}

/// Whether what is lifted is about to turn in the hand, with hysteresis.
pub(super) fn turns(finger: &FingerPercept, turned: bool, context: &Context<'_>) -> bool {
    context.carried_m > 0.0 && finger.torsion > if turned { TORSION_OFF } else { TORSION_ON }
}

/// A patch that is sheared everywhere alike slides, or was loaded and pressed together. Under a steady load it slides.
pub(super) fn slips_grossly(finger: &FingerPercept, context: &Context<'_>) -> bool {
    let alike = finger.utilisation_now > ALIKE && finger.utilisation > ALIKE_ABOVE;
    finger.gross_slip_s > context.settings.grasp.slip_gross_s || (hangs(context) && alike)
}

pub(super) fn is_loading(finger: &FingerPercept, context: &Context<'_>) -> bool {
    let settings = &context.settings.grasp;
    let tremble_n = if context.hangs {
        TREMBLE_SHARE * finger.tangential_n
    } else {
        0.0
    };
    let blind = !finger.shows_slip && finger.friction == 0.0;
    finger.increment_n > settings.dr_n.max(tremble_n)
        && (blind || finger.utilisation > settings.slip_loading)
}
