//! Controller events, one record each.

use crate::code::code;
use crate::joints::Mode;
use crate::module::ModuleId;
use crate::payload::payload;
use crate::reason_record::ReasonRecord;
use crate::stamp::{Hand, Stamp};
use crate::text::Text;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// Kind of an event.
    EventKind as "atas.EventKind.v1" {
        /// A module became active.
        MODULE_ON = 1, "module-on";
        /// A module became inactive.
        MODULE_OFF = 2, "module-off";
        /// A fingertip made contact.
        TOUCH_ON = 3, "touch-on";
        /// A fingertip lost contact.
        TOUCH_OFF = 4, "touch-off";
        /// The state of a goal changed; `value` is the new state.
        GOAL = 5, "goal";
        /// A task entered the step named in `text`.
        STEP = 6, "step";
        /// The mode changed because of `reason`.
        MODE = 7, "mode";
        /// The stiffness probe ended; `value` is in N/m, `text` is F_2.
        STIFFNESS = 8, "stiffness";
        /// A tolerated fault, described by `reason`.
        WARNING = 9, "warning";
    }
}

payload! {
    /// One event. Ordered by `stamp.sequence`; a gap means that events were dropped because the
    /// queue was full.
    ModuleEvent as "atas.ModuleEvent.v1" {
        /// `captured_ns` is the time of the tick.
        pub stamp: Stamp,
        /// Tick of the event.
        pub tick: u64,
        /// Kind of the event.
        pub kind: EventKind,
        /// Module, if applicable.
        pub module: ModuleId,
        /// Hand, if applicable.
        pub hand: Hand,
        /// Fingertip of the hand, if applicable.
        pub finger: u32,
        /// Mode after the event.
        pub mode: Mode,
        /// Written as zero.
        pub pad: u32,
        /// Value that triggered the event, SI units.
        pub value: f64,
        /// Threshold of that value, SI units.
        pub threshold: f64,
        /// Reason of a mode change, goal change or warning.
        pub reason: ReasonRecord,
        /// Name, if applicable.
        pub text: Text<16>,
    }
}
