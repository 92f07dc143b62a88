//! Teleoperation (not in the paper): tracks the targets that a client streams.
//!
//! The hand moves within limits of speed, acceleration and jerk ([`crate::teleop`]). It brakes
//! without a target and while the fingers close. Slip can slow it, and other modules control the
//! grip. Free fingers open to the requested width; a touched fingertip blocks motion into the
//! contact.

use super::{Context, Module, PoseCommand, Proposal, Roles};
use crate::perception::Percept;
use crate::teleop::{MotionLimiter, SpeedLimits};
use nalgebra::Vector3;
use robot_model::GraspPose;
use shm_schemas::ModuleId;

/// Share of a contact force along a coordinate that blocks this coordinate (design choice: 17°).
/// Blocking single coordinates keeps the hand between its pose and its target, hence within every
/// box that contains both.
const BLOCKING_SHARE: f64 = 0.3;

/// Rise at lifting speed, m (design choice: the object has then left its support and the grip is
/// established).
const INITIAL_RISE_M: f64 = 0.005;

#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Teleop {
    /// `None` while the hand is at rest.
    limiter: Option<MotionLimiter>,
    /// Height at which the grip began, m; `None` while the fingers are free.
    held_from_m: Option<f64>,
    has_risen: bool,
}

impl Module for Teleop {
    const ID: ModuleId = ModuleId::TELEOP;
    const ROLES: Roles = Roles {
        moves_hand: true,
        ..Roles::NONE
    };

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let lead = context.teleop_target;
        let free = lead.is_some() && !context.object.all_touched;
        let settings = &context.settings.teleop;
        let speed_m_s = self.speed_m_s(free, context);
        let follower = self
            .limiter
            .get_or_insert_with(|| MotionLimiter::new(context.hand.pose));
        if !free {
            follower.set_fingers(context.hand.pose);
        }
        let wanted = lead.map(|lead| {
            if free {
                clear_of_contacts(lead.pose, percept, context)
            } else {
                lead.pose
            }
        });
        let speeds = SpeedLimits {
            move_m_s: settings.move_m_s,
            turn_rad_s: settings.turn_rad_s,
            finger_m_s: settings.finger_m_s,
            speed_up_s: settings.speed_up_s,
            smooth_s: settings.smooth_s,
        };
        let share = (speed_m_s / settings.move_m_s).min(1.0) * context.hand.carry_scale.max(0.0);
        let frame = follower.step_towards(wanted.as_ref(), &speeds, share, context.step_s);
        Proposal {
            active: wanted.is_some(),
            pose: Some(PoseCommand {
                pose: frame,
                with_fingers: free,
                arrived: false,
            }),
            ..Proposal::default()
        }
    }
}

impl Teleop {
    /// Returns the highest hand speed, m/s: lifting speed until the object has left its support.
    fn speed_m_s(&mut self, free: bool, context: &Context<'_>) -> f64 {
        let settings = context.settings;
        let height_m = context.hand.pose.centre_m.z;
        if !context.object.all_touched {
            (self.held_from_m, self.has_risen) = (None, false);
        }
        if free {
            return settings.teleop.move_m_s;
        }
        self.has_risen |= height_m - *self.held_from_m.get_or_insert(height_m) > INITIAL_RISE_M;
        if self.has_risen {
            settings.teleop.carry_m_s
        } else {
            settings.motion.lift_m_s
        }
    }
}

/// Returns the target pose without motion into touched fingertips.
fn clear_of_contacts(wanted: GraspPose, percept: &Percept, context: &Context<'_>) -> GraspPose {
    let now_m = context.hand.pose.centre_m;
    let mut centre_m = wanted.centre_m;
    for (finger, base_from_tip) in percept.fingertips.iter().zip(context.hand.base_from_tip) {
        let force_n: Vector3<f64> = base_from_tip.rotation * finger.force_tip_n;
        let floor_n = BLOCKING_SHARE * force_n.norm();
        for axis in 0..3 {
            let presses = (wanted.centre_m[axis] - now_m[axis]) * force_n[axis] < 0.0;
            if finger.in_contact && presses && force_n[axis].abs() > floor_n {
                centre_m[axis] = now_m[axis];
            }
        }
    }
    GraspPose { centre_m, ..wanted }
}
