//! Which commands a robot obeys.
//!
//! It trusts nobody. A command is obeyed if it is whole (sealed, for exactly these joints, every number finite), valid for a
//! moment and not for ever, newer than the last of its writer, from the writer that is obeyed or, when its last command has
//! expired, from another; and if no joint would have to move faster than it can. When an obeyed command expires, the robot
//! holds its positions with zero velocity: that keeps the grip.

use crate::capacity::{HANDS, JOINTS};
use crate::joints::{JointCommand, JointState};
use crate::stamp::Stamp;

/// Longest time for which a command may be valid, ns (ours: the most that `safety.valid_s` allows).
const VALIDITY_MAX_NS: u64 = 100_000_000;
/// Share of a joint's top speed that a command may ask for (ours: the top speed and what rounding adds).
const SPEED_SHARE: f64 = 1.05;
/// What a step may be wider than the top speed times the time for which the last command was followed, s of top speed: the one margin
/// (ours: eight commands, as the daemon's gate allows).
const MARGIN_S: f64 = 0.008;

/// What the joints follow. Beyond the robot's own joints both are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orders {
    /// Positions, rad.
    pub position_rad: [f64; JOINTS],
    /// Velocities to feed forward, rad/s.
    pub velocity_rad_s: [f64; JOINTS],
}

impl Orders {
    /// To stand still at these positions, rad, of at most [`JOINTS`] joints.
    #[must_use]
    pub fn holding(position_rad: &[f64]) -> Self {
        Self {
            position_rad: padded(position_rad),
            velocity_rad_s: [0.0; JOINTS],
        }
    }
}

/// A command that is obeyed.
#[derive(Clone, Copy, Debug)]
pub struct Accepted {
    /// What the joints follow.
    pub orders: Orders,
    /// Who ordered it, and as which in the series.
    pub stamp: Stamp,
    /// Until when, ns.
    pub valid_until_ns: u64,
    /// What the command says of each hand's grip, N; see [`JointCommand::grip_limit_n`].
    pub grip_limit_n: [f64; HANDS],
}

impl Accepted {
    /// Tells the next daemon of this command, as the one in force.
    pub fn tell(&self, state: &mut JointState) {
        state.grip_limit_n = self.grip_limit_n;
        state.command_epoch = self.stamp.writer_epoch;
        state.command_sequence = self.stamp.sequence;
        state.command_valid_until_ns = self.valid_until_ns;
    }
}

/// The judge of arriving commands.
#[derive(Clone, Copy, Debug)]
pub struct Obedience {
    joints: usize,
    speed_max_rad_s: [f64; JOINTS],
    start_rad: [f64; JOINTS],
    /// The last command that was accepted, and when.
    newest: Option<(Accepted, u64)>,
    refused: u32,
}

impl Obedience {
    /// For a robot of at most [`JOINTS`] joints that stand at these positions, rad, and move as fast as this, rad/s. It has
    /// as many joints as both lists have.
    #[must_use]
    pub fn at(start_rad: &[f64], speed_max_rad_s: &[f64]) -> Self {
        Self {
            joints: start_rad.len().min(speed_max_rad_s.len()).min(JOINTS),
            speed_max_rad_s: padded(speed_max_rad_s),
            start_rad: padded(start_rad),
            newest: None,
            refused: 0,
        }
    }

    /// The command, if it keeps the contract; counted if not.
    pub fn accept(&mut self, command: &JointCommand, now_ns: u64) -> Option<Accepted> {
        let accepted = Accepted {
            orders: Orders {
                position_rad: padded(&command.position_rad[..self.joints]),
                velocity_rad_s: padded(&command.velocity_rad_s[..self.joints]),
            },
            stamp: command.stamp,
            valid_until_ns: command.valid_until_ns,
            grip_limit_n: command.grip_limit_n,
        };
        let keeps = self.is_whole(command, &accepted.orders)
            && command.valid_until_ns >= now_ns
            && command.valid_until_ns.saturating_sub(now_ns) <= VALIDITY_MAX_NS
            && self.is_next(&accepted.stamp, now_ns)
            && self.is_reachable(&accepted.orders, now_ns);
        if !keeps {
            self.refused = self.refused.saturating_add(1);
            return None;
        }
        self.newest = Some((accepted, now_ns));
        Some(accepted)
    }

    /// Commands refused so far.
    #[must_use]
    pub fn refused(&self) -> u32 {
        self.refused
    }

    /// Whether a command follows the last one. One that has expired is followed by any: the line is free again.
    fn is_next(&self, stamp: &Stamp, now_ns: u64) -> bool {
        let Some((newest, _)) = self
            .newest
            .filter(|(newest, _)| newest.valid_until_ns >= now_ns)
        else {
            return true;
        };
        let ahead = stamp.sequence.wrapping_sub(newest.stamp.sequence);
        stamp.writer_epoch == newest.stamp.writer_epoch && (1..=u64::MAX / 2).contains(&ahead)
    }

    /// Whether the joints can be there in time, and need not move faster than they can. Whoever ordered the last command could be on
    /// the way for as long as it was valid; then the joints stood still, and whoever goes on begins there.
    fn is_reachable(&self, orders: &Orders, now_ns: u64) -> bool {
        let start = (&self.start_rad, 0);
        let (from_rad, followed_ns) = self.newest.as_ref().map_or(start, |(newest, then_ns)| {
            let until_ns = now_ns.min(newest.valid_until_ns);
            (
                &newest.orders.position_rad,
                until_ns.saturating_sub(*then_ns),
            )
        });
        let within_s = MARGIN_S + followed_ns as f64 * 1e-9;
        (0..self.joints).all(|joint| {
            let top_rad_s = SPEED_SHARE * self.speed_max_rad_s[joint];
            let step_rad = (orders.position_rad[joint] - from_rad[joint]).abs();
            step_rad <= top_rad_s * within_s && orders.velocity_rad_s[joint].abs() <= top_rad_s
        })
    }

    /// Sealed, for exactly these joints, every number finite.
    fn is_whole(&self, command: &JointCommand, orders: &Orders) -> bool {
        let mut numbers = orders.position_rad.iter().chain(&orders.velocity_rad_s);
        command.is_intact()
            && command.joint_count as usize == self.joints
            && numbers.all(|value| value.is_finite())
    }
}

/// These values, then zeros.
fn padded(values: &[f64]) -> [f64; JOINTS] {
    core::array::from_fn(|joint| values.get(joint).copied().unwrap_or(0.0))
}
