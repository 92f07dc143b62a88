//! Status of the daemon and of the sensor processes.

use crate::capacity::{FINGERS, HANDS};
use crate::goal::{GoalKind, GoalState};
use crate::joints::Mode;
use crate::payload::payload;
use crate::reason_record::ReasonRecord;
use crate::stamp::{Hand, Stamp};
use crate::text::Text;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

payload! {
    /// Percentiles of a duration since the start, ns.
    Percentiles as "atas.Percentiles.v1" {
        /// Median.
        pub p50_ns: u64,
        /// 99th percentile.
        pub p99_ns: u64,
        /// 99.9th percentile.
        pub p999_ns: u64,
        /// Maximum.
        pub max_ns: u64,
        /// Number of samples.
        pub count: u64,
    }
}

payload! {
    /// Status of one hand's sensor. Counts are since the start of the daemon.
    HandStatus as "atas.HandStatus.v1" {
        /// Accepted frames.
        pub frames: u64,
        /// Lost frames, from gaps in the sequence.
        pub lost: u64,
        /// Duplicate frames.
        pub duplicates: u64,
        /// Frames that arrived after a newer one.
        pub reordered: u64,
        /// Frames with a wrong checksum.
        pub corrupt: u64,
        /// Frames with a stamp too far in the past or future.
        pub mistimed: u64,
        /// Frames of another writer, hand or layout.
        pub foreign: u64,
        /// Readings masked because they are not finite or out of range.
        pub masked_elements: u64,
        /// Restarts of the sensor process.
        pub restarts: u64,
        /// Contacts per fingertip, with hysteresis.
        pub touches: [u64; FINGERS],
        /// Writer epoch of the pinned writer.
        pub writer_epoch: u64,
        /// Age of the newest accepted frame, ns; `u64::MAX` before the first.
        pub age_ns: u64,
        /// Hash of the configured layout.
        pub layout_hash: u64,
        /// Normal force per fingertip, N.
        pub normal_n: [f32; FINGERS],
        /// Tangential force per fingertip, N.
        pub tangential_n: [f32; FINGERS],
        /// 1 if the configuration requires this hand.
        pub required: u32,
        /// Bit n set: the module with [`crate::ModuleId`] n is active.
        pub modules_active: u32,
    }
}

payload! {
    /// Status of the joint feedback.
    JointStatus as "atas.JointStatus.v1" {
        /// Accepted joint states.
        pub states: u64,
        /// Unused joint states, from gaps in the sequence: lost, or superseded within one tick.
        pub lost: u64,
        /// Rejected joint states.
        pub rejected: u64,
        /// Age of the newest joint state, ns; `u64::MAX` before the first.
        pub age_ns: u64,
    }
}

/// Bits of [`Status::flags`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StatusFlags;

impl StatusFlags {
    /// Real-time scheduling or memory locking is not available: timing is best effort.
    pub const DEGRADED: u32 = 1;
    /// Lock-step with virtual time.
    pub const LOCKSTEP: u32 = 1 << 1;
    /// The tick thread runs under `SCHED_FIFO`.
    pub const REALTIME: u32 = 1 << 2;
    /// Memory is locked.
    pub const MEMORY_LOCKED: u32 = 1 << 3;
    /// Ticks are phase-locked to the frame stamps.
    pub const PHASE_LOCKED: u32 = 1 << 4;
    /// Deep idle states of the cores are disabled.
    pub const KEPT_AWAKE: u32 = 1 << 5;
    /// Sense-only mode: the daemon commands no robot.
    pub const SENSE_ONLY: u32 = 1 << 6;
}

payload! {
    /// Status of the daemon, 50 Hz.
    Status as "atas.Status.v3" {
        /// `captured_ns` is the time of the snapshot.
        pub stamp: Stamp,
        /// Version of the daemon.
        pub version: Text<32>,
        /// FNV-1a 64 of the active configuration text.
        pub config_hash: u64,
        /// Start time of the daemon, ns of `CLOCK_MONOTONIC`. In lock-step: virtual time of the
        /// first tick, 0 before it.
        pub started_ns: u64,
        /// Process id.
        pub pid: u32,
        /// [`StatusFlags`].
        pub flags: u32,
        /// Mode of the daemon.
        pub mode: Mode,
        /// Tick rate, Hz.
        pub rate_hz: u32,
        /// Reason of the mode HOLD, SAFE_STOP or FAULT.
        pub reason: ReasonRecord,
        /// Executed ticks.
        pub ticks: u64,
        /// Missed ticks: their time had passed before they could begin.
        pub missed_ticks: u64,
        /// Ticks that began more than a tenth of a period late.
        pub late_ticks: u64,
        /// Ticks started by the arrival of the expected frames.
        pub ticks_on_arrival: u64,
        /// Ticks started by the timeout because an expected frame did not arrive.
        pub ticks_without_frame: u64,
        /// Records dropped because the queue to the supervisor was full.
        pub dropped_records: u64,
        /// Active or last goal, 0 if none.
        pub goal_id: u64,
        /// Kind of that goal.
        pub goal_kind: GoalKind,
        /// State of that goal.
        pub goal_state: GoalState,
        /// Task step.
        pub step: Text<16>,
        /// Name of a user-defined task, else empty.
        pub task: Text<32>,
        /// Reason, if the goal ended without success.
        pub goal_reason: ReasonRecord,
        /// Wake-up delay of the ticks.
        pub wake: Percentiles,
        /// Age of the newest frame at the tick.
        pub frame_age: Percentiles,
        /// Duration of the tick computation.
        pub tick: Percentiles,
        /// Time from the sensor stamp to the command.
        pub sensor_to_command: Percentiles,
        /// Per hand.
        pub hands: [HandStatus; HANDS],
        /// Joint feedback.
        pub joints: JointStatus,
    }
}

payload! {
    /// Status of a sensor device from its sensor process, about 10 Hz and once at exit.
    SensorStatus as "atas.SensorStatus.v1" {
        /// `captured_ns` is the time of the snapshot.
        pub stamp: Stamp,
        /// Driver name, for example `optoforce`.
        pub driver: Text<32>,
        /// Device name, for example a tty.
        pub device: Text<64>,
        /// Hand of the sensor.
        pub hand: Hand,
        /// 1 while the device delivers data.
        pub alive: u32,
        /// Valid frames read from the device.
        pub frames: u64,
        /// Lost frames, from gaps in the device's counter.
        pub lost: u64,
        /// Bytes outside valid frames.
        pub junk_bytes: u64,
        /// Frame candidates with a wrong checksum.
        pub checksum_failures: u64,
        /// Frames whose status word reports an error or overload.
        pub device_errors: u64,
        /// Last status word of the device.
        pub device_status: u32,
        /// Written as zero.
        pub pad: u32,
    }
}
