//! Control: everything a person or a service manager asks of the daemon besides goals.

use crate::code::code;
use crate::payload::payload;
use crate::stamp::Stamp;
use crate::text::Text;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// What is asked.
    ControlOp as "atas.ControlOp.v1" {
        /// Stop now and latch (SAFE_STOP).
        ESTOP = 1, "estop";
        /// Leave SAFE_STOP. The robot then waits in HOLD until nothing is in doubt; HOLD ends by itself.
        RECOVER = 2, "recover";
        /// Read the parameter `name`.
        PARAM_GET = 3, "param-get";
        /// Set the parameter `name` to `value`.
        PARAM_SET = 4, "param-set";
        /// Name the parameter with the index `value`.
        PARAM_LIST = 5, "param-list";
        /// Take the present reading of the hand with index `value` as zero force.
        BIAS = 6, "bias";
        /// Read the configuration files again.
        RELOAD = 7, "reload";
        /// Cancel the goal whose id is written in `name`, in decimal; nothing if it has ended.
        CANCEL = 8, "cancel";
        /// In lock-step: let virtual time go on to the tick with the index `value`, also without a goal. It stands still there.
        ADVANCE = 9, "advance";
    }
}

code! {
    /// How it went.
    ControlOutcome as "atas.ControlOutcome.v1" {
        /// Done.
        DONE = 1, "done";
        /// Refused; `text` says why.
        REFUSED = 2, "refused";
        /// The daemon does not know the operation or the name.
        UNKNOWN = 3, "unknown-request";
    }
}

payload! {
    /// One request.
    ControlRequest as "atas.ControlRequest.v1" {
        /// `captured_ns` is when the client sent it.
        pub stamp: Stamp,
        /// What is asked.
        pub op: ControlOp,
        /// Written as zero.
        pub pad: u32,
        /// Its number, where it has one.
        pub value: f64,
        /// Its name, where it has one.
        pub name: Text<64>,
    }
}

payload! {
    /// The answer: exactly one per request, given after the request took effect.
    ControlReply as "atas.ControlReply.v1" {
        /// `captured_ns` is when the daemon answered.
        pub stamp: Stamp,
        /// How it went.
        pub outcome: ControlOutcome,
        /// Written as zero.
        pub pad: u32,
        /// The value asked for.
        pub value: f64,
        /// The lowest value allowed, for parameters.
        pub lower: f64,
        /// The highest value allowed, for parameters.
        pub upper: f64,
        /// Of a parameter its name, and on a second line what it means; else a sentence that says why not.
        pub text: Text<256>,
    }
}
