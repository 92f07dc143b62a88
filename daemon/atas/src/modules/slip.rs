//! Module 2, slip (paper II.b (1)): "if partial slippage occurs, grasping force increasing behavior
//! continues, and otherwise the behavior is stopped (slippage is estimated by whether tangential
//! force increment dF_t exceeds threshold dr)".
//!
//! The rule dF_t > dr alone fails: smooth sliding has dF_t = 0, and closing on a sliding contact
//! raises dF_t itself. Partial slip appears in the force distribution, as the friction utilisation
//! S. The module is active while
//!
//! * (a) S exceeds `slip_on`, until it falls below `slip_off` (0.84 of both in teleoperation),
//! * (b) gross slip is detected,
//! * (c) S exceeds `slip_loading` and dF_t > dr (the paper's rule, gated by S where friction is
//!   known),
//! * (d) the torsion ratio exceeds one half: an object held off-centre turns before it slips out,
//! * (e) the load of a suspended object drops; this needs no friction coefficient, or
//! * (f) a suspended object suddenly loads the grip more than lift verification has shown it to
//!   hold. The closing speed then follows from the missing force.
//!
//! Grip minimisation disables (a) and (c), because a slip is harmless there. A verified grip
//! disables (a) to (c): misaligned faces cause uniform shear, and a poor sensor misreads friction.
//! Before verification, a missing load response disables the same three.
//!
//! The module stays active for `slip_latch_s` after the last of the causes (a) to (e). Meanwhile it
//! slows the hand if closing can still help.

use super::drop_detector::DropDetector;
use super::load_growth::LoadGrowth;
use super::load_response::LoadResponse;
use super::{Context, Finding, Module, Proposal, Roles, force_range_n, force_up_n};
use crate::perception::{ContactPercept, Percept};
use robot_model::GRASP_SIDES;
use shm_schemas::ModuleId;

/// Torsion ratios at which turning begins and ends (design choice: at 0.6 the first objects have
/// turned by 10°).
const TORSION_ON: f64 = 0.5;
const TORSION_OFF: f64 = 0.45;
/// Momentary utilisation of uniform shear in a suspended object, and utilisation below which the
/// contact is only lightly loaded (design choice).
const UNIFORM_SHEAR: f64 = 0.935;
const UNIFORM_SHEAR_LOADED: f64 = 0.8;
/// Horizontal distance to the end of the path that counts as conveying, m (design choice).
const CONVEYING_MIN_M: f64 = 0.001;
/// Swing time of a load after a change of speed, s (design choice).
const BRAKING_S: f64 = 0.15;
/// Factor on the closing speed while the object drops (design choice: at 1 it drops by
/// millimetres).
const DROP_SPEED_FACTOR: f64 = 3.0;
/// Factor on `slip_on` and `slip_off` in teleoperation (design choice), which has no lift
/// verification. Kinetic friction is a tenth lower than static, so S falls below `slip_on` during a
/// slide. Drag around a curved face raises the friction reading by up to a fifth. Cost: one
/// hundredth more over-grip.
const TELEOP_SHARE: f64 = 0.84;
/// Carried distance above which only the hand holds the object, m (design choice).
const SUSPENDED_MIN_M: f64 = 0.001;
/// Usual and largest share of the tangential force that vibration changes within the window of dF_t
/// (design choice).
pub(super) const STEADY_SHARE: f64 = 0.06;
const VIBRATION_SHARE: f64 = 0.1;

#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Slip {
    /// Per side: cause (a) holds.
    slipping: [bool; GRASP_SIDES],
    /// Per side: cause (d) holds.
    turning: [bool; GRASP_SIDES],
    /// Load while the object is suspended and not being set down.
    drop_detector: DropDetector,
    load_response: LoadResponse,
    load_growth: LoadGrowth,
    /// Remaining latch time, s.
    latch_s: f64,
    /// Factor on the hand speed in the previous tick, and remaining swing time, s.
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
        let brakes = self.is_braking(context);
        let load_n = is_suspended(context).then_some(down_n);
        let falls = self.drop_detector.update(load_n, brakes, percept.step_s);
        let mut cause = falls;
        for (turning, side) in self.turning.iter_mut().zip(&percept.sides) {
            *turning = is_turning(side, *turning, context);
            cause |= *turning;
        }
        let in_vain = self.load_is_unresponsive(percept, down_n, context);
        for (slipping, side) in self.slipping.iter_mut().zip(&percept.sides) {
            *slipping = exceeds_utilisation(side, *slipping, context);
            let nears = *slipping || (!brakes && is_loading(side, context));
            let slips = slips_grossly(side, context) || (nears && !context.minimises_grip);
            cause |= slips && !context.verified && !in_vain;
        }
        let (weakest_n, strongest_n) = force_range_n(percept);
        let following_m_s = self.load_growth.closing_m_s(
            context.verified_grip.filter(|_| is_suspended(context)),
            (weakest_n, strongest_n),
            context.thresholds.f2_n,
            &context.compression,
            percept.delay_s,
        );
        self.latch_s = if cause {
            settings.slip_latch_s
        } else {
            self.latch_s - context.step_s
        };
        let slips = cause || self.latch_s > 0.0;
        // Setting down ends the slip sooner than braking. The load of a lifted object does not
        // depend on speed, so braking only makes it swing.
        let loads = !is_suspended(context) || is_conveying(context);
        let helps = loads && strongest_n < context.thresholds.f2_n && context.lowering_m.is_none();
        let closing_m_s = match (slips, falls) {
            (_, true) => DROP_SPEED_FACTOR * settings.enhance_m_s,
            (true, false) => settings.enhance_m_s,
            (false, false) => 0.0,
        }
        .max(following_m_s);
        Proposal {
            active: slips || self.load_growth.is_active(),
            closing_m_s: [closing_m_s; GRASP_SIDES],
            carry_ceiling: if slips && helps {
                settings.slip_carry_scale
            } else {
                1.0
            },
            finding: Finding {
                slips: falls,
                ..Finding::default()
            },
            ..Proposal::default()
        }
    }
}

impl Slip {
    /// Returns whether closing does not increase the load of the lifted object.
    fn load_is_unresponsive(
        &mut self,
        percept: &Percept,
        down_n: f64,
        context: &Context<'_>,
    ) -> bool {
        let lifts = context.carried_m > 0.0 && !context.suspended;
        let normal_n: f64 = percept.sides.iter().map(|f| f.normal_n).sum();
        self.load_response
            .is_unresponsive(lifts.then_some((normal_n, down_n)), percept.step_s)
    }

    /// Returns whether a change of speed makes the carried object swing.
    fn is_braking(&mut self, context: &Context<'_>) -> bool {
        let before = core::mem::replace(&mut self.carry_scale, context.carry_scale);
        self.braking_s = if before == context.carry_scale {
            self.braking_s - context.step_s
        } else {
            BRAKING_S
        };
        is_suspended(context) && self.braking_s > 0.0
    }
}

/// Returns whether only the hand carries the object, outside lowering.
fn is_suspended(context: &Context<'_>) -> bool {
    context.suspended && context.carried_m > SUSPENDED_MIN_M && context.lowering_m.is_none()
}

/// Returns whether the hand moves sideways, where its acceleration loads the grip.
fn is_conveying(context: &Context<'_>) -> bool {
    let ahead_m = context.path.end().centre_m - context.pose.centre_m;
    ahead_m.xy().norm() > CONVEYING_MIN_M
}

/// Returns whether the friction utilisation exceeds its limit, with hysteresis.
pub(super) fn exceeds_utilisation(
    finger: &ContactPercept,
    used_up: bool,
    context: &Context<'_>,
) -> bool {
    let settings = &context.settings.grasp;
    let share = if context.teleop_target.is_some() {
        TELEOP_SHARE
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

/// Returns whether the lifted object is about to turn in the hand, with hysteresis.
pub(super) fn is_turning(finger: &ContactPercept, turned: bool, context: &Context<'_>) -> bool {
    context.carried_m > 0.0 && finger.torsion > if turned { TORSION_OFF } else { TORSION_ON }
}

/// Returns whether the contact slips grossly. Under a steady load, uniform shear is gross slip;
/// otherwise it may result from loading and closing at once.
pub(super) fn slips_grossly(finger: &ContactPercept, context: &Context<'_>) -> bool {
    let alike = finger.utilisation_now > UNIFORM_SHEAR && finger.utilisation > UNIFORM_SHEAR_LOADED;
    finger.gross_slip_s > context.settings.grasp.slip_gross_s || (is_suspended(context) && alike)
}

pub(super) fn is_loading(finger: &ContactPercept, context: &Context<'_>) -> bool {
    let settings = &context.settings.grasp;
    let tremble_n = if context.suspended {
        VIBRATION_SHARE * finger.tangential_n
    } else {
        0.0
    };
    let blind = !finger.shows_incipient_slip && finger.friction == 0.0;
    finger.increment_n > settings.dr_n.max(tremble_n)
        && (blind || finger.utilisation > settings.slip_loading)
}
