//! Follow (ours, not in the paper): leads the hand after the targets that a client streams.
//!
//! Between two targets the hand moves within limits of speed, acceleration and jerk ([`crate::follow`]); without one, or while
//! the fingers take hold, it brakes. It is one proposal among the others: while it moves the hand, slip slows it down, and
//! what the fingers do on an object is theirs to say. While they are free they open as the client wants, and what a fingertip
//! touches is not pressed: the way into it is cut off.

use super::{Context, Module, PoseCommand, Proposal, Roles};
use crate::follow::{Follower, Speeds};
use crate::perception::Percept;
use nalgebra::Vector3;
use robot_model::GraspFrame;
use shm_schemas::ModuleId;

/// Share of a contact's force along a coordinate from which on moving along it counts as moving into the contact (ours: 17°).
/// Cut off coordinate by coordinate, the hand stays between where it is and its target, so within every box that has both.
const ALONG_SHARE: f64 = 0.3;

/// Rise of what is held up to which the hand moves as slowly as a lift does, m (ours: its support has let go of it by then, and
/// the fingers have found the force that it needs).
const PROVED_M: f64 = 0.005;

/// How the hand moves, and how far it has proved its grip.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Follow {
    /// `None` while the hand stands.
    follower: Option<Follower>,
    /// Height at which it took hold, m; `None` while the fingers are free.
    held_from_m: Option<f64>,
    proved: bool,
}

impl Module for Follow {
    const ID: ModuleId = ModuleId::FOLLOW;
    const ROLES: Roles = Roles {
        moves_hand: true,
        ..Roles::NONE
    };

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let lead = context.lead;
        let free = lead.is_some() && !context.all_touched;
        let settings = &context.settings.follow;
        let speed_m_s = self.speed_m_s(free, context);
        let follower = self
            .follower
            .get_or_insert_with(|| Follower::at(context.frame));
        if !free {
            follower.take_fingers(context.frame);
        }
        let wanted = lead.map(|lead| {
            if free {
                clear_of_contacts(lead.frame, percept, context)
            } else {
                lead.frame
            }
        });
        let speeds = Speeds {
            move_m_s: settings.move_m_s,
            turn_rad_s: settings.turn_rad_s,
            finger_m_s: settings.finger_m_s,
            speed_up_s: settings.speed_up_s,
            smooth_s: settings.smooth_s,
        };
        let share = (speed_m_s / settings.move_m_s).min(1.0) * context.carry_scale.max(0.0);
        let frame = follower.towards(wanted.as_ref(), &speeds, share, context.step_s);
        Proposal {
            active: wanted.is_some(),
            pose: Some(PoseCommand {
                frame,
                with_fingers: free,
                arrived: false,
            }),
            ..Proposal::default()
        }
    }
}

impl Follow {
    /// Highest speed of the hand now, m/s. What was just taken hold of goes slowly until it has left its support.
    fn speed_m_s(&mut self, free: bool, context: &Context<'_>) -> f64 {
        let settings = context.settings;
        let height_m = context.frame.centre_m.z;
        if !context.all_touched {
            (self.held_from_m, self.proved) = (None, false);
        }
        if free {
            return settings.follow.move_m_s;
        }
        self.proved |= height_m - *self.held_from_m.get_or_insert(height_m) > PROVED_M;
        if self.proved {
            settings.follow.carry_m_s
        } else {
            settings.motion.lift_m_s
        }
    }
}

/// The same pose, but not farther into what presses a fingertip.
fn clear_of_contacts(wanted: GraspFrame, percept: &Percept, context: &Context<'_>) -> GraspFrame {
    let now_m = context.frame.centre_m;
    let mut centre_m = wanted.centre_m;
    for (finger, base_from_tip) in percept.fingers.iter().zip(context.base_from_tip) {
        let force_n: Vector3<f64> = base_from_tip * finger.force_tip_n;
        let floor_n = ALONG_SHARE * force_n.norm();
        for axis in 0..3 {
            let presses = (wanted.centre_m[axis] - now_m[axis]) * force_n[axis] < 0.0;
            if finger.in_contact && presses && force_n[axis].abs() > floor_n {
                centre_m[axis] = now_m[axis];
            }
        }
    }
    GraspFrame { centre_m, ..wanted }
}
