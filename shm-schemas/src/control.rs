//! Control requests: operations of the daemon other than goals.

use crate::code::code;
use crate::payload::payload;
use crate::stamp::Stamp;
use crate::text::Text;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// Operation of a control request.
    ControlOp as "atas.ControlOp.v1" {
        /// Stops immediately and latches SAFE_STOP.
        ESTOP = 1, "estop";
        /// Leaves SAFE_STOP. The robot stays in HOLD until all faults have cleared; HOLD ends by
        /// itself.
        RECOVER = 2, "recover";
        /// Reads the parameter `name`.
        PARAM_GET = 3, "param-get";
        /// Sets the parameter `name` to `value`.
        PARAM_SET = 4, "param-set";
        /// Returns the name of the parameter with the index `value`.
        PARAM_LIST = 5, "param-list";
        /// Takes the present reading of the hand with the index `value` as zero force.
        BIAS = 6, "bias";
        /// Reloads the configuration files.
        RELOAD = 7, "reload";
        /// Cancels the goal whose decimal id is in `name`; no effect if the goal has ended.
        CANCEL = 8, "cancel";
        /// Lock-step only: advances virtual time to the tick with the index `value`, even without a
        /// goal, and pauses there.
        ADVANCE = 9, "advance";
    }
}

code! {
    /// Result of a control request.
    ControlOutcome as "atas.ControlOutcome.v1" {
        /// Done.
        DONE = 1, "done";
        /// Refused; `text` has the reason.
        REFUSED = 2, "refused";
        /// Unknown operation or name.
        UNKNOWN = 3, "unknown-request";
    }
}

payload! {
    /// A control request.
    ControlRequest as "atas.ControlRequest.v1" {
        /// `captured_ns` is when the client sent it.
        pub stamp: Stamp,
        /// Operation.
        pub op: ControlOp,
        /// Written as zero.
        pub pad: u32,
        /// Numeric argument, if any.
        pub value: f64,
        /// Name argument, if any.
        pub name: Text<64>,
    }
}

payload! {
    /// Reply to a control request: exactly one, sent after the request took effect.
    ControlReply as "atas.ControlReply.v1" {
        /// `captured_ns` is when the daemon answered.
        pub stamp: Stamp,
        /// Result.
        pub outcome: ControlOutcome,
        /// Written as zero.
        pub pad: u32,
        /// Requested value.
        pub value: f64,
        /// Lower limit of the parameter.
        pub lower: f64,
        /// Upper limit of the parameter.
        pub upper: f64,
        /// For a parameter: name, and description on a second line. For a refusal: the reason.
        pub text: Text<256>,
    }
}
