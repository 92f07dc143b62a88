//! Validation of joint commands on the robot side.
//!
//! A robot executes a command only if:
//!
//! * it is well-formed: intact checksum, matching joint count, finite values;
//! * it is valid now, and for a limited time;
//! * it is newer than the previous command of the same writer, or that command has expired;
//! * no joint would exceed its speed limit.
//!
//! When an executed command expires, the robot holds its positions with zero velocity, which keeps
//! the grip.

use crate::capacity::{HANDS, JOINTS};
use crate::joints::{JointCommand, JointState};
use crate::stamp::Stamp;

/// Longest validity of a command, ns. Design choice: the upper bound of `safety.valid_s`.
const VALIDITY_MAX_NS: u64 = 100_000_000;
/// Factor on a joint's speed limit up to which commands are accepted. Design choice: covers
/// rounding.
const SPEED_FACTOR_MAX: f64 = 1.05;
/// Step tolerance beyond speed limit times execution time of the previous command, as a time at the
/// speed limit, s. Design choice: eight command periods, as in the gate of the daemon.
const STEP_MARGIN_S: f64 = 0.008;

/// Joint set-points. Entries beyond the joints of the robot are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointSetpoints {
    /// Positions, rad or m.
    pub position: [f64; JOINTS],
    /// Velocity feed-forward, rad/s or m/s.
    pub velocity: [f64; JOINTS],
}

impl JointSetpoints {
    /// Creates set-points that hold these positions, rad or m, of at most [`JOINTS`] joints.
    #[must_use]
    pub fn holding(position: &[f64]) -> Self {
        Self {
            position: padded(position),
            velocity: [0.0; JOINTS],
        }
    }
}

/// An accepted command.
#[derive(Clone, Copy, Debug)]
pub struct Accepted {
    /// Joint set-points.
    pub setpoints: JointSetpoints,
    /// Writer and sequence number of the command.
    pub stamp: Stamp,
    /// End of validity, ns.
    pub valid_until_ns: u64,
    /// Grip force limit per hand, N; see [`JointCommand::grip_limit_n`].
    pub grip_limit_n: [f64; HANDS],
}

impl Accepted {
    /// Writes the command in force to the joint state, so that the next daemon can continue from
    /// it.
    pub fn write_to(&self, state: &mut JointState) {
        state.grip_limit_n = self.grip_limit_n;
        state.command_epoch = self.stamp.writer_epoch;
        state.command_sequence = self.stamp.sequence;
        state.command_valid_until_ns = self.valid_until_ns;
    }
}

/// Validator of received commands.
///
/// ```
/// use shm_schemas::{CommandValidator, JointCommand};
///
/// // A robot with two joints rejects a command without joint values.
/// let mut validator = CommandValidator::new(&[0.0, 0.1], &[1.0, 1.0]);
/// assert!(validator.accept(&JointCommand::default(), 0).is_none());
/// assert_eq!(validator.rejected(), 1);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct CommandValidator {
    joints: usize,
    speed_max_rad_s: [f64; JOINTS],
    start: [f64; JOINTS],
    /// Last accepted command and its time of arrival, ns.
    newest: Option<(Accepted, u64)>,
    rejected: u32,
}

impl CommandValidator {
    /// Creates a validator for joints at the positions `start` with the speed limits
    /// `speed_max_rad_s`, at most [`JOINTS`]. The joint count is the length of the shorter list.
    #[must_use]
    pub fn new(start: &[f64], speed_max_rad_s: &[f64]) -> Self {
        Self {
            joints: start.len().min(speed_max_rad_s.len()).min(JOINTS),
            speed_max_rad_s: padded(speed_max_rad_s),
            start: padded(start),
            newest: None,
            rejected: 0,
        }
    }

    /// Returns the command if it is valid; otherwise counts it as rejected.
    pub fn accept(&mut self, command: &JointCommand, now_ns: u64) -> Option<Accepted> {
        let accepted = Accepted {
            setpoints: JointSetpoints {
                position: padded(&command.position[..self.joints]),
                velocity: padded(&command.velocity[..self.joints]),
            },
            stamp: command.stamp,
            valid_until_ns: command.valid_until_ns,
            grip_limit_n: command.grip_limit_n,
        };
        let keeps = self.is_well_formed(command, &accepted.setpoints)
            && command.valid_until_ns >= now_ns
            && command.valid_until_ns.saturating_sub(now_ns) <= VALIDITY_MAX_NS
            && self.is_in_sequence(&accepted.stamp, now_ns)
            && self.is_reachable(&accepted.setpoints, now_ns);
        if !keeps {
            self.rejected = self.rejected.saturating_add(1);
            return None;
        }
        self.newest = Some((accepted, now_ns));
        Some(accepted)
    }

    /// Returns the number of rejected commands.
    #[must_use]
    pub fn rejected(&self) -> u32 {
        self.rejected
    }

    /// Returns true if the command follows the last accepted one in sequence. After that one has
    /// expired, any writer is accepted.
    fn is_in_sequence(&self, stamp: &Stamp, now_ns: u64) -> bool {
        let Some((newest, _)) = self
            .newest
            .filter(|(newest, _)| newest.valid_until_ns >= now_ns)
        else {
            return true;
        };
        let ahead = stamp.sequence.wrapping_sub(newest.stamp.sequence);
        stamp.writer_epoch == newest.stamp.writer_epoch && (1..=u64::MAX / 2).contains(&ahead)
    }

    /// Returns true if no joint has to exceed its speed limit. The joints can have moved towards
    /// the last command while it was valid; after that they stood still.
    fn is_reachable(&self, orders: &JointSetpoints, now_ns: u64) -> bool {
        let start = (&self.start, 0);
        let (from_rad, followed_ns) = self.newest.as_ref().map_or(start, |(newest, then_ns)| {
            let until_ns = now_ns.min(newest.valid_until_ns);
            (
                &newest.setpoints.position,
                until_ns.saturating_sub(*then_ns),
            )
        });
        let within_s = STEP_MARGIN_S + followed_ns as f64 * 1e-9;
        (0..self.joints).all(|joint| {
            let top_rad_s = SPEED_FACTOR_MAX * self.speed_max_rad_s[joint];
            let step_rad = (orders.position[joint] - from_rad[joint]).abs();
            step_rad <= top_rad_s * within_s && orders.velocity[joint].abs() <= top_rad_s
        })
    }

    /// Returns true if the checksum, the joint count and all values are valid.
    fn is_well_formed(&self, command: &JointCommand, orders: &JointSetpoints) -> bool {
        let mut numbers = orders.position.iter().chain(&orders.velocity);
        command.is_intact()
            && command.joint_count as usize == self.joints
            && numbers.all(|value| value.is_finite())
    }
}

/// Pads the values with zeros.
fn padded(values: &[f64]) -> [f64; JOINTS] {
    core::array::from_fn(|joint| values.get(joint).copied().unwrap_or(0.0))
}
