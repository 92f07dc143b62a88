//! What the robot's joints do and what they are told.

use crate::capacity::{HANDS, JOINTS};
use crate::code::code;
use crate::payload::payload;
use crate::stamp::Stamp;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
use zerocopy::IntoBytes;

payload! {
    /// Measured joints, left 11 then right 11 for the built-in robot, and what they are told to do.
    ///
    /// The robot outlives the daemon. What it tells of the command in force lets the next daemon go on from there: a grip is
    /// what the servos are commanded beyond where the fingers are, so who began again from measured positions would let go.
    JointState as "atas.JointState.v3" {
        /// `captured_ns` is when the encoders were read.
        pub stamp: Stamp,
        /// Joints that carry data, at most [`JOINTS`].
        pub joint_count: u32,
        /// Joints whose `commanded_rad` means something: `joint_count`, or 0 for a robot that cannot tell.
        pub commanded_count: u32,
        /// Measured positions, rad.
        pub position_rad: [f64; JOINTS],
        /// Measured velocities, rad/s.
        pub velocity_rad_s: [f64; JOINTS],
        /// Measured efforts, N·m; zero where the drive does not measure.
        pub effort_n_m: [f64; JOINTS],
        /// Positions that the servos hold now, rad: of the last command obeyed, also when it has expired.
        pub commanded_rad: [f64; JOINTS],
        /// [`JointCommand::grip_limit_n`] of that command, 0 before the first.
        pub grip_limit_n: [f64; HANDS],
        /// Epoch of the writer of that command, 0 before the first.
        pub command_epoch: u64,
        /// Sequence of that command.
        pub command_sequence: u64,
        /// Until when that command is valid, ns; it has expired if this has passed.
        pub command_valid_until_ns: u64,
        /// Written as zero.
        pub pad: u32,
        /// CRC-32 (IEEE) of every byte before this field.
        pub crc32: u32,
    }
}

crate::crc::sealed!(JointState);

payload! {
    /// What the joints shall do now. Published every tick, also in HOLD: the command is the heartbeat.
    ///
    /// The consumer enforces [`JointCommand::valid_until_ns`]: on expiry it holds the last commanded positions with
    /// zero velocity, which keeps the last safe grip force. Opening the hand is never the default stop.
    JointCommand as "atas.JointCommand.v2" {
        /// `captured_ns` is the tick's time.
        pub stamp: Stamp,
        /// The command must not be obeyed after this time, `CLOCK_MONOTONIC` nanoseconds.
        pub valid_until_ns: u64,
        /// The tick that produced the command.
        pub tick: u64,
        /// Sequence of the newest [`JointState`] that the command has seen; lock-step waits for it.
        pub answers_sequence: u64,
        /// Mode of the daemon.
        pub mode: Mode,
        /// Joints that carry data, at most [`JOINTS`].
        pub joint_count: u32,
        /// Commanded positions, rad.
        pub position_rad: [f64; JOINTS],
        /// Velocity feed-forward, rad/s; zero in HOLD.
        pub velocity_rad_s: [f64; JOINTS],
        /// F_2, the most that what each hand holds may be pressed with, N; 0 for an empty hand. The robot does nothing with it but
        /// tell it in [`JointState`]: so a limit outlives the daemon that knows it.
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
        /// Everything fresh, no goal.
        READY = 1, "ready";
        /// A goal is being pursued.
        RUN = 2, "run";
        /// Something is in doubt: positions and grip are kept, the cause is watched.
        HOLD = 3, "hold";
        /// Stopped and latched until an explicit recover.
        SAFE_STOP = 4, "safe-stop";
        /// The daemon itself failed; latched until restart.
        FAULT = 5, "fault";
    }
}
