//! Payload header (stamp and sequence number, as in a ROS header) and hand codes.

use crate::code::code;
use crate::payload::payload;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

payload! {
    /// Writer, time and sequence number of a payload.
    Stamp as "atas.Stamp.v1" {
        /// Sequence number of this writer, from 0; a gap means lost payloads.
        pub sequence: u64,
        /// Capture time of the content, not its sending time, ns of `CLOCK_MONOTONIC`.
        pub captured_ns: u64,
        /// Random number, drawn at each start of the writer. A reader pins it; a change means that
        /// the writer restarted.
        pub writer_epoch: u64,
    }
}

code! {
    /// Left or right hand.
    Hand as "atas.Hand.v1" {
        /// Left hand: joints 0 to 10 of the built-in robot.
        LEFT = 0, "left";
        /// Right hand: joints 11 to 21 of the built-in robot.
        RIGHT = 1, "right";
    }
}

impl Hand {
    /// Both hands, in the order of every per-hand array.
    pub const BOTH: [Self; 2] = [Self::LEFT, Self::RIGHT];

    /// Index of the hand in per-hand arrays.
    ///
    /// # Errors
    /// `None` if the code is unknown.
    #[must_use]
    pub fn index(self) -> Option<usize> {
        self.is_known().then_some(self.0 as usize)
    }
}
