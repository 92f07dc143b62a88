//! One record per tick, for those who look closely.

use crate::capacity::{FINGERS, HANDS, STAGES};
use crate::joints::Mode;
use crate::payload::payload;
use crate::stamp::Stamp;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

payload! {
    /// What one fingertip felt, after perception.
    FingerReport as "atas.FingerReport.v1" {
        /// F_n in the contact-patch frame, N.
        pub normal_n: f32,
        /// F_t in the contact-patch frame, N.
        pub tangential_n: f32,
        /// dF_t over its window, N.
        pub tangential_increment_n: f32,
        /// S, friction utilisation: 1 means gross slip.
        pub utilisation: f32,
        /// S from the present friction reading, without memory.
        pub utilisation_now: f32,
        /// Estimated friction coefficient.
        pub friction: f32,
        /// Commanded closing speed, m/s, positive when closing.
        pub closing_m_s: f32,
        /// 1 while the fingertip touches something.
        pub in_contact: u32,
    }
}

payload! {
    /// What one hand felt and wanted.
    HandReport as "atas.HandReport.v1" {
        /// Sequence of the newest frame that the tick used.
        pub frame_sequence: u64,
        /// Age of that frame at the tick, ns.
        pub frame_age_ns: u64,
        /// Frames that arrived since the tick before.
        pub frames: u32,
        /// Bit n set: the module with [`crate::ModuleId`] n is active.
        pub modules_active: u32,
        /// Index of the task's step.
        pub step: u32,
        /// F_1, N.
        pub f1_n: f32,
        /// F_2, N.
        pub f2_n: f32,
        /// Object stiffness, N/m.
        pub stiffness_n_m: f32,
        /// Commanded position of the hand's centre, base frame, m.
        pub centre_m: [f64; 3],
        /// Per finger.
        pub fingers: [FingerReport; FINGERS],
    }
}

payload! {
    /// What one tick did.
    TickReport as "atas.TickReport.v1" {
        /// `captured_ns` is the tick's time.
        pub stamp: Stamp,
        /// Index of the tick; a gap means missed ticks.
        pub tick: u64,
        /// Ticks missed so far.
        pub missed_ticks: u64,
        /// Active goal, 0 if none.
        pub goal_id: u64,
        /// Sequence of the joint state that the tick used.
        pub joint_sequence: u64,
        /// How late the tick began, ns.
        pub wake_late_ns: u32,
        /// Mode after the tick.
        pub mode: Mode,
        /// Duration of each stage, ns: intake, perception, modules, kinematics, safety, publish, report, recording.
        pub stage_ns: [u32; STAGES],
        /// From the newest frame's capture to the command's publication, ns.
        pub sensor_to_command_ns: u32,
        /// CRC-32 of the published command.
        pub command_crc32: u32,
        /// Per hand.
        pub hands: [HandReport; HANDS],
    }
}

impl TickReport {
    /// Names of the stages, in the order of [`TickReport::stage_ns`].
    pub const STAGE_NAMES: [&'static str; STAGES] = [
        "intake",
        "perception",
        "modules",
        "kinematics",
        "safety",
        "publish",
        "report",
        "recording",
    ];
}
