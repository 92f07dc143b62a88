//! Joint state, joint command and daemon mode.

use crate::capacity::{HANDS, JOINTS};
use crate::code::code;
use crate::payload::payload;
use crate::stamp::Stamp;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
use zerocopy::IntoBytes;

payload! {
    /// Measured joints (built-in robot: 11 left, then 11 right) and the command in force.
    ///
    /// The robot process outlives the daemon, so it reports the command in force and a new daemon
    /// continues from it. Servos hold a grip by being commanded beyond the measured finger
    /// positions; restarting from measured positions would release the object.
    JointState as "atas.JointState.v3" {
        /// `captured_ns` is the time at which the encoders were read.
        pub stamp: Stamp,
        /// Number of joints with data, at most [`JOINTS`].
        pub joint_count: u32,
        /// Number of valid entries in `commanded_position`: `joint_count`, or 0 if the robot cannot
        /// report them.
        pub commanded_count: u32,
        /// Measured positions, rad or m.
        pub position: [f64; JOINTS],
        /// Measured velocities, rad/s or m/s.
        pub velocity: [f64; JOINTS],
        /// Measured efforts, N·m or N; zero if the drive does not measure them.
        pub effort: [f64; JOINTS],
        /// Positions held by the servos, rad or m: those of the last executed command, even if it
        /// has expired.
        pub commanded_position: [f64; JOINTS],
        /// [`JointCommand::grip_limit_n`] of that command, 0 before the first.
        pub grip_limit_n: [f64; HANDS],
        /// Writer epoch of that command, 0 before the first.
        pub command_epoch: u64,
        /// Sequence number of that command.
        pub command_sequence: u64,
        /// End of validity of that command, ns.
        pub command_valid_until_ns: u64,
        /// Written as zero.
        pub pad: u32,
        /// CRC-32 (IEEE) of every byte before this field.
        pub crc32: u32,
    }
}

crate::crc::sealed!(JointState);

payload! {
    /// Joint command of one tick. It is published every tick, also in HOLD, and serves as
    /// heartbeat.
    ///
    /// The consumer enforces [`JointCommand::valid_until_ns`]: on expiry it holds the last
    /// commanded positions with zero velocity, which keeps the last safe grip force. Opening the
    /// hand is never the default stop.
    JointCommand as "atas.JointCommand.v2" {
        /// `captured_ns` is the time of the tick.
        pub stamp: Stamp,
        /// End of validity, ns of `CLOCK_MONOTONIC`; the command must not be executed later.
        pub valid_until_ns: u64,
        /// Tick that produced the command.
        pub tick: u64,
        /// Sequence number of the newest [`JointState`] used by the command; lock-step waits for
        /// it.
        pub answers_sequence: u64,
        /// Mode of the daemon.
        pub mode: Mode,
        /// Number of joints with data, at most [`JOINTS`].
        pub joint_count: u32,
        /// Commanded positions, rad or m.
        pub position: [f64; JOINTS],
        /// Velocity feed-forward, rad/s or m/s; zero in HOLD.
        pub velocity: [f64; JOINTS],
        /// Force limit F_2 per hand for the held object, N; 0 for an empty hand. The robot only
        /// copies it to [`JointState`], so that the limit survives a restart of the daemon.
        pub grip_limit_n: [f64; HANDS],
        /// Written as zero.
        pub pad: u32,
        /// CRC-32 (IEEE) of every byte before this field.
        pub crc32: u32,
    }
}

crate::crc::sealed!(JointCommand);

code! {
    /// Mode of the daemon, ordered by severity.
    Mode as "atas.Mode.v1" {
        /// Waiting for the first valid frames and joint states.
        INIT = 0, "init";
        /// All inputs are fresh; no goal.
        READY = 1, "ready";
        /// A goal is in progress.
        RUN = 2, "run";
        /// A fault is present: positions and grip are kept until it clears.
        HOLD = 3, "hold";
        /// Stopped and latched until a recover request.
        SAFE_STOP = 4, "safe-stop";
        /// Internal failure of the daemon; latched until restart.
        FAULT = 5, "fault";
    }
}
