//! Stop requests, sent over a separate socket (`shm_bus::stop`).

use crate::code::code;
use crate::payload::payload;
use crate::stamp::Stamp;
use crate::text::Text;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// Result of a stop request.
    StopOutcome as "atas.StopOutcome.v1" {
        /// A tick processed the stop: commands hold still from that tick on.
        STOPPED = 1, "stopped";
        /// The stop is pending: the tick is frozen, or virtual time is paused in lock-step.
        WAITING = 2, "waiting";
    }
}

payload! {
    /// A stop request. Any other data at the stop socket also stops the robot, without a reason.
    StopRequest as "atas.StopRequest.v1" {
        /// `captured_ns` is when the client sent it.
        pub stamp: Stamp,
        /// Reason, for the log.
        pub reason: Text<96>,
    }
}

payload! {
    /// The answer to a stop.
    StopAnswer as "atas.StopAnswer.v1" {
        /// `captured_ns` is the arrival time of the stop; `sequence` counts received stops.
        pub stamp: Stamp,
        /// Result.
        pub outcome: StopOutcome,
        /// Process id of the daemon.
        pub pid: u32,
    }
}
