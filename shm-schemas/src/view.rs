//! What the robot feels and where it is, for those who only look.

use crate::capacity::HANDS;
use crate::frame::HandFrame;
use crate::joints::JointState;
use crate::payload::payload;
use crate::stamp::Stamp;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

payload! {
    /// The newest frames and joint state, some 60 times a second: the streams of the 1 kHz loop have a closed set of peers,
    /// this one is for screens.
    View as "atas.View.v2" {
        /// `captured_ns` is the tick's time; `sequence` counts the views.
        pub stamp: Stamp,
        /// The tick that left it.
        pub tick: u64,
        /// Per hand, 1 once a frame has come.
        pub has_frame: [u32; HANDS],
        /// 1 once a joint state has come.
        pub has_joints: u32,
        /// Written as zero.
        pub pad: u32,
        /// The newest frame of each hand, as it came, unchecked.
        pub frames: [HandFrame; HANDS],
        /// The newest joint state, as it came, unchecked.
        pub joints: JointState,
    }
}
