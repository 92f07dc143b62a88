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
//! * (d) the torsion ratio exceeds one half, or one fifth until the grip is known to hold the load:
//!   an object held off-centre turns before it slips out,
//! * (e) the load of a suspended object drops; this needs no friction coefficient, or
//! * (f) a suspended object suddenly loads the grip more than lift verification has shown it to
//!   hold. The closing speed then follows from the missing force.
//!
//! Causes (a) to (c) interpret the force pattern. They are void while the grip is known to hold its
//! load ([`HeldObject::load_is_held`](crate::held_object::HeldObject)): misaligned faces cause
//! uniform shear, and a poor sensor misreads friction. Grip minimisation searches the limit of
//! friction, where a slip is harmless, so (a) and (c) do not count there.
//!
//! The module stays active for `slip_latch_s` after the last of the causes (a) to (e). Meanwhile it
//! slows the hand if closing can still help.

use super::load_growth::LoadGrowth;
use super::{Context, Module, Proposal, Roles};
use crate::perception::{ContactPercept, Percept};
use robot_model::PerSide;
use shm_schemas::ModuleId;

/// Torsion ratios at which turning begins and ends (design choice: at 0.6 the first objects have
/// turned by 10°).
const TORSION_ON: f64 = 0.5;
const TORSION_OFF: f64 = 0.45;
/// Torsion ratios at which turning begins and ends until the grip is known to hold the load. Design
/// choice, measured with centres of mass up to 5 mm beside the grip: with the pair above, objects
/// tilt by 4° on an edge of their base while they leave the support, and land 5 mm beside their
/// place.
const LIFTING_TORSION_ON: f64 = 0.2;
const LIFTING_TORSION_OFF: f64 = 0.18;
/// Path speed factor while an object begins to tilt (design choice: the grip grows by newtons while
/// the hand rises by tenths of a millimetre).
const TILTING_CARRY_SCALE: f64 = 0.03;
/// Momentary utilisation of uniform shear in a suspended object, and utilisation below which the
/// contact is only lightly loaded (design choice).
const UNIFORM_SHEAR: f64 = 0.935;
const UNIFORM_SHEAR_LOADED: f64 = 0.8;
/// Horizontal distance to the end of the path that counts as conveying, m (design choice).
const CONVEYING_MIN_M: f64 = 0.001;
/// Factor on the closing speed while the object drops (design choice: at 1 it drops by
/// millimetres).
const DROP_SPEED_FACTOR: f64 = 3.0;
/// Factor on `slip_on` and `slip_off` in teleoperation (design choice), which has no lift
/// verification. Kinetic friction is a tenth lower than static, so S falls below `slip_on` during a
/// slide. Drag around a curved face raises the friction reading by up to a fifth. Cost: one
/// hundredth more over-grip.
const TELEOP_SHARE: f64 = 0.84;
/// Usual and largest share of the tangential force that vibration changes within the window of dF_t
/// (design choice).
pub(super) const STEADY_SHARE: f64 = 0.06;
const VIBRATION_SHARE: f64 = 0.1;

#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Slip {
    /// Per side: cause (a) holds.
    slipping: PerSide<bool>,
    /// Per side: cause (d) holds.
    turning: PerSide<bool>,
    load_growth: LoadGrowth,
    /// Remaining latch time, s.
    latch_s: f64,
}

impl Module for Slip {
    const ID: ModuleId = ModuleId::SLIP;
    const ROLES: Roles = Roles {
        closes_fingers: true,
        ..Roles::NONE
    };

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let (settings, object) = (&context.settings.grasp, context.object);
        let mut cause = object.drops;
        for (turning, side) in self.turning.iter_mut().zip(&percept.sides) {
            *turning = is_turning(side, *turning, context);
            cause |= *turning;
        }
        for (slipping, side) in self.slipping.iter_mut().zip(&percept.sides) {
            *slipping = exceeds_utilisation(side, *slipping, context);
            let nears = *slipping || (!object.swings && is_loading(side, context));
            let slips = slips_grossly(side, context) || (nears && !object.minimises_grip);
            cause |= slips && !object.load_is_held;
        }
        let forces_n = percept.normal_range_n();
        let following_m_s = self.load_growth.closing_m_s(
            object.grip.filter(|_| object.carried_freely),
            forces_n,
            object.thresholds.f2_n,
            &context.hand.compression,
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
        let loads = !object.carried_freely || is_conveying(context);
        let helps = loads && forces_n.1 < object.thresholds.f2_n && context.lowering_m.is_none();
        let closing_m_s = match (slips, object.drops) {
            (_, true) => DROP_SPEED_FACTOR * settings.enhance_m_s,
            (true, false) => settings.enhance_m_s,
            (false, false) => 0.0,
        }
        .max(following_m_s);
        let tilts = !object.suspended && self.turning.iter().any(|turning| *turning);
        Proposal {
            active: slips || self.load_growth.is_active(),
            closing_m_s: PerSide::repeat(closing_m_s),
            carry_ceiling: match (slips && helps, tilts) {
                (true, true) => TILTING_CARRY_SCALE,
                (true, false) => settings.slip_carry_scale,
                (false, _) => 1.0,
            },
            ..Proposal::default()
        }
    }
}

/// Returns whether the hand moves sideways, where its acceleration loads the grip.
fn is_conveying(context: &Context<'_>) -> bool {
    let ahead_m = context.path.end().centre_m - context.hand.pose.centre_m;
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
    let object = context.object;
    let holds = object.suspended || object.minimises_grip || object.load_is_held;
    let limit = match (holds, turned) {
        (true, false) => TORSION_ON,
        (true, true) => TORSION_OFF,
        (false, false) => LIFTING_TORSION_ON,
        (false, true) => LIFTING_TORSION_OFF,
    };
    object.carried_m > 0.0 && finger.torsion > limit
}

/// Returns whether the contact slips grossly. Under a steady load, uniform shear is gross slip;
/// otherwise it may result from loading and closing at once.
pub(super) fn slips_grossly(finger: &ContactPercept, context: &Context<'_>) -> bool {
    let alike = finger.utilisation_now > UNIFORM_SHEAR && finger.utilisation > UNIFORM_SHEAR_LOADED;
    finger.gross_slip_s > context.settings.grasp.slip_gross_s
        || (context.object.carried_freely && alike)
}

pub(super) fn is_loading(finger: &ContactPercept, context: &Context<'_>) -> bool {
    let settings = &context.settings.grasp;
    let tremble_n = if context.object.suspended {
        VIBRATION_SHARE * finger.tangential_n
    } else {
        0.0
    };
    let blind = !finger.shows_incipient_slip && finger.friction == 0.0;
    finger.increment_n > settings.dr_n.max(tremble_n)
        && (blind || finger.utilisation > settings.slip_loading)
}
