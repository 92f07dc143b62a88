//! Joint drives: validation, latency and expiry of joint commands.
//!
//! A command takes effect [`LATENCY_MS`] after its arrival. Its positions are approached linearly
//! within one millisecond, then held; its velocities are fed forward for that millisecond only.
//! Loss and expiry of commands therefore end in the same safe state: zero velocity at the last
//! commanded positions, which keeps the grip.
//!
//! [`CommandValidator`] decides which commands take effect. Every joint state reports the commanded
//! positions, so that a restarted daemon can continue from them.

use robot_model::RobotVector;
use shm_schemas::capacity::JOINTS;
use shm_schemas::{Accepted, CommandValidator, JointCommand, JointSetpoints, JointState};

/// Delay from a command's arrival to its execution, ms (tactile design: 2 ms command latency).
pub const LATENCY_MS: usize = 2;
#[derive(Clone, Debug)]
pub(crate) struct Drive {
    obedience: CommandValidator,
    joints: usize,
    /// Commands within the latency; `slot` is the next one to execute.
    pending: [Option<Accepted>; LATENCY_MS],
    slot: usize,
    held: JointSetpoints,
    executed: Option<Accepted>,
    /// The last executed command has not expired.
    in_force: bool,
    expired: u32,
}

impl Drive {
    /// Returns a drive that holds these positions, with these joint speed limits.
    pub(crate) fn holding(position: RobotVector, speed_max_rad_s: RobotVector) -> Self {
        Self {
            obedience: CommandValidator::new(&position, &speed_max_rad_s),
            joints: position.len(),
            pending: [None; LATENCY_MS],
            slot: 0,
            held: JointSetpoints::holding(&position),
            executed: None,
            in_force: false,
            expired: 0,
        }
    }

    /// Takes the command that arrived during this tick, if any; returns the set-points of this
    /// tick.
    pub(crate) fn setpoints(
        &mut self,
        arrived: Option<&JointCommand>,
        now_ns: u64,
    ) -> JointSetpoints {
        let accepted = arrived.and_then(|command| self.obedience.accept(command, now_ns));
        let due = core::mem::replace(&mut self.pending[self.slot], accepted);
        self.slot = (self.slot + 1) % LATENCY_MS;
        self.held.velocity = [0.0; JOINTS];
        match due {
            Some(due) if due.valid_until_ns >= now_ns => {
                self.held = due.setpoints;
                self.executed = Some(due);
                self.in_force = true;
            }
            Some(_) => self.expired += 1,
            None => {}
        }
        let expired = self
            .executed
            .is_some_and(|last| last.valid_until_ns < now_ns);
        if self.in_force && expired {
            self.in_force = false;
            self.expired += 1;
        }
        self.held
    }

    /// Writes the commanded positions to the joint state.
    pub(crate) fn report(&self, state: &mut JointState) {
        state.commanded_count = self.joints as u32;
        state.commanded_position = self.held.position;
        if let Some(last) = &self.executed {
            last.write_to(state);
        }
    }

    /// Returns the number of rejected commands plus expiries without a successor.
    pub(crate) fn expired(&self) -> u32 {
        self.expired + self.obedience.rejected()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const MS_NS: u64 = 1_000_000;
    const JOINTS: usize = 22;

    fn command(position: f64, valid_until_ns: u64) -> JointCommand {
        let mut command = JointCommand {
            joint_count: JOINTS as u32,
            valid_until_ns,
            ..Default::default()
        };
        command.position[..JOINTS].fill(position);
        command.velocity[..JOINTS].fill(0.5);
        command.seal();
        command
    }

    fn drive() -> Drive {
        Drive::holding(
            RobotVector::zeros(JOINTS),
            RobotVector::repeat(JOINTS, 200.0),
        )
    }

    #[test]
    fn command_takes_effect_after_the_latency() {
        let mut drive = drive();
        let arrivals = [Some(command(1.0, 10 * MS_NS)), None, None, None];
        let followed: Vec<(f64, f64)> = (0..)
            .zip(&arrivals)
            .map(|(tick, arrived)| drive.setpoints(arrived.as_ref(), tick * MS_NS))
            .map(|orders| (orders.position[3], orders.velocity[3]))
            .collect();
        assert_eq!(followed, [(0.0, 0.0), (0.0, 0.0), (1.0, 0.5), (1.0, 0.0)]);
        assert_eq!(drive.expired(), 0);
    }

    #[test]
    fn expiry_holds_positions_and_counts_once() {
        let mut drive = drive();
        drive.setpoints(Some(&command(1.0, 5 * MS_NS)), 0);
        let last = (1..20)
            .map(|tick| drive.setpoints(None, tick * MS_NS))
            .last();
        assert_eq!(
            last.map(|orders| (orders.position[0], orders.velocity[0])),
            Some((1.0, 0.0))
        );
        assert_eq!(drive.expired(), 1);
    }

    #[test]
    fn command_expired_in_transit_is_not_executed() {
        let mut drive = drive();
        drive.setpoints(Some(&command(1.0, MS_NS)), 0);
        let orders = (1..5)
            .map(|tick| drive.setpoints(None, tick * MS_NS))
            .last();
        assert_eq!(orders.map(|orders| orders.position[0]), Some(0.0));
        assert_eq!(drive.expired(), 1);
    }

    /// Regression: any sealed command was executed, at any speed and validity.
    #[test]
    fn invalid_command_changes_nothing() {
        type Change = fn(&mut JointCommand);
        let check = |obeyed: bool, change: Change, now_ms: u64| {
            let mut drive = drive();
            let at = |sequence, position: f64, ms: u64| {
                let mut next = command(position, (ms + 5) * MS_NS);
                (next.stamp.sequence, next.stamp.writer_epoch) = (sequence, 7);
                next
            };
            let mut first = at(100, 1.0, 0);
            first.seal();
            drive.setpoints(Some(&first), 0);
            let mut second = at(101, 1.1, now_ms);
            change(&mut second);
            second.seal();
            drive.setpoints(Some(&second), now_ms * MS_NS);
            let followed = (1..4)
                .map(|ms| drive.setpoints(None, (now_ms + ms) * MS_NS))
                .last();
            let expected_rad = if obeyed { 1.1 } else { 1.0 };
            assert_eq!(
                followed.map(|orders| orders.position[0]),
                Some(expected_rad)
            );
        };
        check(true, |_| {}, 1);
        check(false, |c| c.stamp.sequence = 100, 1);
        check(false, |c| c.stamp.sequence = 99, 1);
        check(false, |c| c.stamp.writer_epoch = 8, 1);
        check(false, |c| c.valid_until_ns = u64::MAX, 1);
        check(false, |c| c.position[0] = 3.0, 1);
        check(false, |c| c.velocity[0] = 250.0, 1);
        check(false, |c| c.joint_count = 23, 1);
        // After the last command has expired, another writer may take over, with any sequence
        // number.
        check(true, |c| c.stamp.writer_epoch = 8, 6);
        check(true, |c| c.stamp.sequence = 3, 6);
    }

    /// Regression: after a pause a command could step by 0.1 s at top speed, 0.34 rad of the
    /// built-in robot.
    #[test]
    fn pause_does_not_widen_the_step_limit() {
        // Step limit: top speed over the last command's 5 ms of validity plus the margin of eight
        // commands.
        let (top_rad_s, valid_ms, margin_ms) = (3.0, 5, 8);
        let widest_rad = 1.05 * top_rad_s * 1e-3 * (valid_ms + margin_ms) as f64;
        let obeyed = |step_rad: f64, after_ms: u64| {
            let still = RobotVector::zeros(JOINTS);
            let mut drive = Drive::holding(still, RobotVector::repeat(JOINTS, top_rad_s));
            let ordered = |position: f64, ms: u64| command(position, (ms + valid_ms) * MS_NS);
            drive.setpoints(Some(&ordered(0.0, 0)), 0);
            let mut second = ordered(step_rad, after_ms);
            second.stamp.sequence = 1;
            second.seal();
            drive.setpoints(Some(&second), after_ms * MS_NS);
            let then = (1..4).map(|ms| drive.setpoints(None, (after_ms + ms) * MS_NS));
            then.last().expect("some").position[0] == step_rad
        };
        for after_ms in [5, 20, 100, 10_000] {
            assert!(obeyed(0.99 * widest_rad, after_ms), "{after_ms} ms");
            assert!(!obeyed(1.01 * widest_rad, after_ms), "{after_ms} ms");
        }
        // Earlier, elapsed time limits the step.
        assert!(!obeyed(0.99 * widest_rad, 1));
    }

    #[test]
    fn executed_command_is_reported() {
        let (mut drive, mut state) = (drive(), JointState::default());
        drive.report(&mut state);
        assert_eq!((state.commanded_position[3], state.command_epoch), (0.0, 0));
        let mut command = command(1.0, 5 * MS_NS);
        (command.stamp.sequence, command.stamp.writer_epoch) = (4, 7);
        command.grip_limit_n = [0.0, 1.5];
        command.seal();
        drive.setpoints(Some(&command), 0);
        for ms in 1..50 {
            drive.setpoints(None, ms * MS_NS);
        }
        drive.report(&mut state);
        assert_eq!(state.commanded_count as usize, JOINTS);
        assert_eq!(
            (state.commanded_position[3], state.command_epoch),
            (1.0, 7),
            "an expired command is also reported"
        );
        assert_eq!(
            (state.command_sequence, state.command_valid_until_ns),
            (4, 5 * MS_NS)
        );
        assert_eq!(state.grip_limit_n, [0.0, 1.5]);
    }

    proptest! {
        /// Property: the joints keep their set-points after any damaged command.
        #[test]
        fn a_damaged_command_changes_nothing(
            joint in 0..JOINTS,
            bad in prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(f64::NEG_INFINITY)],
            damage in 0..4_u8,
            bit in 0..8 * core::mem::offset_of!(JointCommand, pad),
        ) {
            let mut damaged = command(1.0, 10 * MS_NS);
            match damage {
                0 => damaged.position[joint] = bad,
                1 => damaged.velocity[joint] = bad,
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
            let before = drive.setpoints(None, 0);
            for arrived in [Some(&damaged), None, None, None] {
                prop_assert_eq!(drive.setpoints(arrived, MS_NS), before);
            }
            prop_assert_eq!(drive.expired(), 1);
        }
    }
}
