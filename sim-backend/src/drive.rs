//! The drives' side of the command line: what a command must be to be obeyed, when it takes effect, when it lapses.
//!
//! A command takes effect [`LATENCY_MS`] after it arrived. Its positions are approached linearly within one millisecond
//! and then held; its velocities are fed forward for that millisecond only. So whatever stops the commands, whether loss or
//! expiry, ends in the same safe state: zero velocity at the last commanded positions, which keeps the grip.

use robot_model::ROBOT_JOINTS;
use shm_schemas::JointCommand;

/// Time from a command's arrival until the joints obey it, ms (tactile design: 2 ms command latency).
pub const LATENCY_MS: usize = 2;

/// What the joints follow in one millisecond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Orders {
    pub(crate) position_rad: [f64; ROBOT_JOINTS],
    pub(crate) velocity_rad_s: [f64; ROBOT_JOINTS],
}

#[derive(Clone, Copy, Debug)]
struct Accepted {
    orders: Orders,
    valid_until_ns: u64,
}

/// The command line of all joints.
#[derive(Clone, Debug)]
pub(crate) struct Drive {
    /// Commands under way; `slot` is the one that arrives next.
    under_way: [Option<Accepted>; LATENCY_MS],
    slot: usize,
    held: Orders,
    /// When the command in force lapses; `None` when there is none.
    valid_until_ns: Option<u64>,
    expired: u32,
}

impl Drive {
    /// A drive that holds these positions until told otherwise.
    pub(crate) fn holding(position_rad: [f64; ROBOT_JOINTS]) -> Self {
        let held = Orders {
            position_rad,
            velocity_rad_s: [0.0; ROBOT_JOINTS],
        };
        Self {
            under_way: [None; LATENCY_MS],
            slot: 0,
            held,
            valid_until_ns: None,
            expired: 0,
        }
    }

    /// Takes the command that arrived in this millisecond, if any, and returns what the joints follow in it.
    pub(crate) fn orders(&mut self, arrived: Option<&JointCommand>, now_ns: u64) -> Orders {
        let accepted = arrived.and_then(|command| self.accept(command));
        let due = core::mem::replace(&mut self.under_way[self.slot], accepted);
        self.slot = (self.slot + 1) % LATENCY_MS;
        self.held.velocity_rad_s = [0.0; ROBOT_JOINTS];
        if let Some(Accepted {
            orders,
            valid_until_ns,
        }) = due
        {
            self.valid_until_ns = Some(valid_until_ns);
            if valid_until_ns >= now_ns {
                self.held = orders;
            }
        }
        if self
            .valid_until_ns
            .is_some_and(|until_ns| until_ns < now_ns)
        {
            self.valid_until_ns = None;
            self.expired += 1;
        }
        self.held
    }

    /// The command, if it is whole: sealed, for exactly these joints, every number finite.
    fn accept(&mut self, command: &JointCommand) -> Option<Accepted> {
        let orders = Orders {
            position_rad: core::array::from_fn(|joint| command.position_rad[joint]),
            velocity_rad_s: core::array::from_fn(|joint| command.velocity_rad_s[joint]),
        };
        let finite = orders
            .position_rad
            .iter()
            .chain(&orders.velocity_rad_s)
            .all(|value| value.is_finite());
        let whole = command.is_intact() && command.joint_count as usize == ROBOT_JOINTS && finite;
        if !whole {
            self.expired += 1;
            return None;
        }
        Some(Accepted {
            orders,
            valid_until_ns: command.valid_until_ns,
        })
    }

    /// Commands refused, and times that commands expired without a successor.
    pub(crate) fn expired(&self) -> u32 {
        self.expired
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const MS_NS: u64 = 1_000_000;

    fn command(position_rad: f64, valid_until_ns: u64) -> JointCommand {
        let mut command = JointCommand {
            joint_count: ROBOT_JOINTS as u32,
            valid_until_ns,
            ..Default::default()
        };
        command.position_rad[..ROBOT_JOINTS].fill(position_rad);
        command.velocity_rad_s[..ROBOT_JOINTS].fill(0.5);
        command.seal();
        command
    }

    fn drive() -> Drive {
        Drive::holding([0.0; ROBOT_JOINTS])
    }

    #[test]
    fn a_command_is_obeyed_after_the_latency_for_one_millisecond() {
        let mut drive = drive();
        let arrivals = [Some(command(1.0, 10 * MS_NS)), None, None, None];
        let followed: Vec<(f64, f64)> = (0..)
            .zip(&arrivals)
            .map(|(tick, arrived)| drive.orders(arrived.as_ref(), tick * MS_NS))
            .map(|orders| (orders.position_rad[3], orders.velocity_rad_s[3]))
            .collect();
        assert_eq!(followed, [(0.0, 0.0), (0.0, 0.0), (1.0, 0.5), (1.0, 0.0)]);
        assert_eq!(drive.expired(), 0);
    }

    #[test]
    fn expiry_holds_the_last_positions_and_is_counted_once() {
        let mut drive = drive();
        drive.orders(Some(&command(1.0, 5 * MS_NS)), 0);
        let last = (1..20).map(|tick| drive.orders(None, tick * MS_NS)).last();
        assert_eq!(
            last.map(|orders| (orders.position_rad[0], orders.velocity_rad_s[0])),
            Some((1.0, 0.0))
        );
        assert_eq!(drive.expired(), 1);
    }

    #[test]
    fn a_command_that_expired_on_its_way_is_not_obeyed() {
        let mut drive = drive();
        drive.orders(Some(&command(1.0, MS_NS)), 0);
        let orders = (1..5).map(|tick| drive.orders(None, tick * MS_NS)).last();
        assert_eq!(orders.map(|orders| orders.position_rad[0]), Some(0.0));
        assert_eq!(drive.expired(), 1);
    }

    proptest! {
        /// Whatever is wrong with a command, the joints keep what they had.
        #[test]
        fn a_damaged_command_changes_nothing(
            joint in 0..ROBOT_JOINTS,
            bad in prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(f64::NEG_INFINITY)],
            damage in 0..4_u8,
            bit in 0..8 * core::mem::offset_of!(JointCommand, pad),
        ) {
            let mut damaged = command(1.0, u64::MAX);
            match damage {
                0 => damaged.position_rad[joint] = bad,
                1 => damaged.velocity_rad_s[joint] = bad,
                2 => damaged.joint_count = joint as u32,
                _ => {
                    use zerocopy::IntoBytes;
                    damaged.as_mut_bytes()[bit / 8] ^= 1 << (bit % 8);
                }
            }
            if damage < 3 {
                damaged.seal();
            }
            let mut drive = drive();
            let before = drive.orders(None, 0);
            for arrived in [Some(&damaged), None, None, None] {
                prop_assert_eq!(drive.orders(arrived, MS_NS), before);
            }
            prop_assert_eq!(drive.expired(), 1);
        }
    }
}
