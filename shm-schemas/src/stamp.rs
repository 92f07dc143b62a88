//! The stamp at the beginning of every payload (what ROS calls the stamp and the sequence of a header), and which hand
//! a payload speaks of.

use crate::code::code;
use crate::payload::payload;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

payload! {
    /// Who wrote a payload, when, and as which in its series.
    Stamp as "atas.Stamp.v1" {
        /// Counts the payloads of this writer, from 0, without gaps: a gap means that payloads were lost.
        pub sequence: u64,
        /// When the content was true (sensor time, not sending time), nanoseconds of `CLOCK_MONOTONIC`.
        pub captured_ns: u64,
        /// Drawn anew at each start of the writer. A reader pins it; a change means that the writer restarted.
        pub writer_epoch: u64,
    }
}

code! {
    /// Which hand.
    Hand as "atas.Hand.v1" {
        /// The left hand: joints 0 to 10 of the built-in robot.
        LEFT = 0, "left";
        /// The right hand: joints 11 to 21 of the built-in robot.
        RIGHT = 1, "right";
    }
}

impl Hand {
    /// Both hands, in the order of every per-hand array.
    pub const BOTH: [Self; 2] = [Self::LEFT, Self::RIGHT];

    /// The hand's place in per-hand arrays.
    ///
    /// # Errors
    /// `None` when the code names no hand.
    #[must_use]
    pub fn index(self) -> Option<usize> {
        self.is_known().then_some(self.0 as usize)
    }
}
