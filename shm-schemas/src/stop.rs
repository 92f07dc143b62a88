//! Stop: what a person says when everything shall stand still, on a way of its own (`shm_bus::stop`).

use crate::code::code;
use crate::payload::payload;
use crate::stamp::Stamp;
use crate::text::Text;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// What became of a stop.
    StopOutcome as "atas.StopOutcome.v1" {
        /// A tick took it: the commands stand still from that tick on.
        STOPPED = 1, "stopped";
        /// It waits for the next tick, which has not come yet: the tick is frozen, or time stands still in lock-step.
        WAITING = 2, "waiting";
    }
}

payload! {
    /// A stop. Whatever else arrives at the stop socket counts as one too, without a reason.
    StopRequest as "atas.StopRequest.v1" {
        /// `captured_ns` is when the client sent it.
        pub stamp: Stamp,
        /// Why, for the log.
        pub reason: Text<96>,
    }
}

payload! {
    /// The answer to a stop.
    StopAnswer as "atas.StopAnswer.v1" {
        /// `captured_ns` is when the daemon received the stop, `sequence` counts the stops that it received.
        pub stamp: Stamp,
        /// What became of it.
        pub outcome: StopOutcome,
        /// Process id of the daemon.
        pub pid: u32,
    }
}
