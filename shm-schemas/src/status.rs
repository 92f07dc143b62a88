//! How everybody is.

use crate::capacity::{FINGERS, HANDS};
use crate::goal::{GoalKind, GoalState};
use crate::joints::Mode;
use crate::payload::payload;
use crate::reason::Reason;
use crate::stamp::{Hand, Stamp};
use crate::text::Text;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

payload! {
    /// A distribution of durations since the start, ns.
    Percentiles as "atas.Percentiles.v1" {
        /// Median.
        pub p50_ns: u64,
        /// 99th percentile.
        pub p99_ns: u64,
        /// 99.9th percentile.
        pub p999_ns: u64,
        /// Longest.
        pub max_ns: u64,
        /// How many were measured.
        pub count: u64,
    }
}

payload! {
    /// What the daemon thinks of one hand's sensor. All counts since the daemon's start.
    HandStatus as "atas.HandStatus.v1" {
        /// Frames accepted.
        pub frames: u64,
        /// Frames lost, by gaps in the sequence.
        pub lost: u64,
        /// Frames seen twice.
        pub duplicates: u64,
        /// Frames that came after a newer one.
        pub reordered: u64,
        /// Frames that failed their checksum.
        pub corrupt: u64,
        /// Frames stamped too far in the past or in the future.
        pub mistimed: u64,
        /// Frames of another writer, hand or layout.
        pub foreign: u64,
        /// Readings masked because they were not finite or out of range.
        pub masked_elements: u64,
        /// Restarts of the sensor process.
        pub restarts: u64,
        /// Touches per finger, with hysteresis.
        pub touches: [u64; FINGERS],
        /// Epoch of the pinned writer.
        pub writer_epoch: u64,
        /// Age of the newest accepted frame, ns; `u64::MAX` before the first.
        pub age_ns: u64,
        /// Configured layout.
        pub layout_hash: u64,
        /// Normal force per finger, N.
        pub normal_n: [f32; FINGERS],
        /// Tangential force per finger, N.
        pub tangential_n: [f32; FINGERS],
        /// 1 if the configuration wants this hand.
        pub required: u32,
        /// Bit n set: the module with [`crate::ModuleId`] n is active.
        pub modules_active: u32,
    }
}

payload! {
    /// What the daemon thinks of the joint feedback.
    JointStatus as "atas.JointStatus.v1" {
        /// States accepted.
        pub states: u64,
        /// States not taken in, by gaps in the sequence: lost, or superseded by a newer one within one tick.
        pub lost: u64,
        /// States refused.
        pub rejected: u64,
        /// Age of the newest, ns; `u64::MAX` before the first.
        pub age_ns: u64,
    }
}

/// Bits of [`Status::flags`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StatusFlags;

impl StatusFlags {
    /// Real-time scheduling or memory locking was refused: timing is best effort.
    pub const DEGRADED: u32 = 1;
    /// Lock-step: time is virtual.
    pub const LOCKSTEP: u32 = 1 << 1;
    /// The tick thread runs under `SCHED_FIFO`.
    pub const REALTIME: u32 = 1 << 2;
    /// Memory is locked.
    pub const MEMORY_LOCKED: u32 = 1 << 3;
    /// The ticks are locked to the frames' stamps.
    pub const PHASE_LOCKED: u32 = 1 << 4;
    /// The cores are kept from idle states that they wake up from slowly.
    pub const KEPT_AWAKE: u32 = 1 << 5;
    /// There is no robot to move: the daemon was told to sense only.
    pub const SENSE_ONLY: u32 = 1 << 6;
}

payload! {
    /// The daemon's state, 50 Hz.
    Status as "atas.Status.v3" {
        /// `captured_ns` is when the snapshot was taken.
        pub stamp: Stamp,
        /// Version of the daemon.
        pub version: Text<32>,
        /// FNV-1a 64 of the configuration text in force.
        pub config_hash: u64,
        /// When the daemon started, ns of the clock of its stamps: `CLOCK_MONOTONIC`; in lock-step the virtual time of its first
        /// tick, 0 before that.
        pub started_ns: u64,
        /// Process id.
        pub pid: u32,
        /// [`StatusFlags`].
        pub flags: u32,
        /// Mode.
        pub mode: Mode,
        /// Tick rate, Hz.
        pub rate_hz: u32,
        /// Why the mode is HOLD, SAFE_STOP or FAULT.
        pub reason: Reason,
        /// Ticks executed.
        pub ticks: u64,
        /// Ticks missed: their time had passed when the loop came round.
        pub missed_ticks: u64,
        /// Ticks that began more than a tenth of a period late.
        pub late_ticks: u64,
        /// Ticks that began because the frames that they awaited came.
        pub ticks_on_arrival: u64,
        /// Ticks that awaited a frame until the latest moment, in vain.
        pub ticks_in_vain: u64,
        /// Records dropped because the queue to the non-real-time side was full.
        pub dropped_records: u64,
        /// Active or last goal, 0 if none.
        pub goal_id: u64,
        /// Its kind.
        pub goal_kind: GoalKind,
        /// Its state.
        pub goal_state: GoalState,
        /// Its step.
        pub step: Text<16>,
        /// Name of its task if it is one of the user's own, else empty.
        pub task: Text<32>,
        /// Why it ended, if it ended without success.
        pub goal_reason: Reason,
        /// How late ticks begin.
        pub wake: Percentiles,
        /// Age of the newest frame at the tick.
        pub frame_age: Percentiles,
        /// Duration of the tick's body.
        pub tick: Percentiles,
        /// From the sensor's stamp to the command.
        pub sensor_to_command: Percentiles,
        /// Per hand.
        pub hands: [HandStatus; HANDS],
        /// Joint feedback.
        pub joints: JointStatus,
    }
}

payload! {
    /// What a sensor process says of its device, about 10 Hz and once more at its end.
    SensorStatus as "atas.SensorStatus.v1" {
        /// `captured_ns` is when the snapshot was taken.
        pub stamp: Stamp,
        /// The driver, for example `optoforce`.
        pub driver: Text<32>,
        /// The device, for example a tty.
        pub device: Text<64>,
        /// Which hand it feels for.
        pub hand: Hand,
        /// 1 while the device delivers.
        pub alive: u32,
        /// Valid frames read from the device.
        pub frames: u64,
        /// Frames lost, by gaps in the device's own counter.
        pub lost: u64,
        /// Bytes that belong to no valid frame.
        pub junk_bytes: u64,
        /// Candidates that failed their checksum.
        pub checksum_failures: u64,
        /// Frames whose status word reports an error or an overload.
        pub device_errors: u64,
        /// The device's last status word.
        pub device_status: u32,
        /// Written as zero.
        pub pad: u32,
    }
}
