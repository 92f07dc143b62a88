//! Tick reports: one record per tick for debugging and analysis.

use crate::capacity::{FINGERS, HANDS, STAGES};
use crate::joints::Mode;
use crate::payload::payload;
use crate::stamp::Stamp;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

payload! {
    /// Contact state of one fingertip after perception.
    FingerReport as "atas.FingerReport.v1" {
        /// F_n in the contact-patch frame, N.
        pub normal_n: f32,
        /// F_t in the contact-patch frame, N.
        pub tangential_n: f32,
        /// dF_t over its window, N.
        pub tangential_increment_n: f32,
        /// Friction utilisation S; 1 means gross slip.
        pub utilisation: f32,
        /// S from the present friction estimate, without its history.
        pub utilisation_now: f32,
        /// Estimated friction coefficient.
        pub friction: f32,
        /// Commanded closing speed, m/s, positive when closing.
        pub closing_m_s: f32,
        /// 1 while the fingertip is in contact.
        pub in_contact: u32,
    }
}

payload! {
    /// Grasp state and active modules of one hand.
    HandReport as "atas.HandReport.v1" {
        /// Sequence number of the newest frame used by the tick.
        pub frame_sequence: u64,
        /// Age of that frame at the tick, ns.
        pub frame_age_ns: u64,
        /// Frames received since the previous tick.
        pub frames: u32,
        /// Bit n set: the module with [`crate::ModuleId`] n is active.
        pub modules_active: u32,
        /// Index of the task step.
        pub step: u32,
        /// Minimum grip force F_1, N.
        pub f1_n: f32,
        /// Force limit F_2, N.
        pub f2_n: f32,
        /// Object stiffness, N/m.
        pub stiffness_n_m: f32,
        /// Commanded position of the hand's centre, base frame, m.
        pub centre_m: [f64; 3],
        /// Per fingertip.
        pub fingers: [FingerReport; FINGERS],
    }
}

payload! {
    /// Report of one tick.
    TickReport as "atas.TickReport.v1" {
        /// `captured_ns` is the time of the tick.
        pub stamp: Stamp,
        /// Tick index; a gap means missed ticks.
        pub tick: u64,
        /// Ticks missed since the start.
        pub missed_ticks: u64,
        /// Active goal, 0 if none.
        pub goal_id: u64,
        /// Sequence number of the joint state used by the tick.
        pub joint_sequence: u64,
        /// Wake-up delay of the tick, ns.
        pub wake_late_ns: u32,
        /// Mode after the tick.
        pub mode: Mode,
        /// Duration of each stage, ns: intake, perception, modules, kinematics, safety, publish,
        /// report, recording.
        pub stage_ns: [u32; STAGES],
        /// Time from the capture of the newest frame to the publication of the command, ns.
        pub sensor_to_command_ns: u32,
        /// CRC-32 of the published command.
        pub command_crc32: u32,
        /// Per hand.
        pub hands: [HandReport; HANDS],
    }
}

impl TickReport {
    /// Stage names, in the order of [`TickReport::stage_ns`].
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
