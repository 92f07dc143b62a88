//! Sensor and joint data for observers such as screens.

use crate::capacity::HANDS;
use crate::frame::HandFrame;
use crate::joints::JointState;
use crate::payload::payload;
use crate::stamp::Stamp;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

payload! {
    /// Newest frames and joint state, at about 60 Hz. The 1 kHz streams have a closed set of peers;
    /// observers read this one instead.
    View as "atas.View.v2" {
        /// `captured_ns` is the tick's time; `sequence` counts the views.
        pub stamp: Stamp,
        /// Tick that published the view.
        pub tick: u64,
        /// Per hand: 1 after the first frame.
        pub has_frame: [u32; HANDS],
        /// 1 after the first joint state.
        pub has_joints: u32,
        /// Written as zero.
        pub pad: u32,
        /// Newest frame of each hand, as received, not validated.
        pub frames: [HandFrame; HANDS],
        /// Newest joint state, as received, not validated.
        pub joints: JointState,
    }
}
