//! Events: what happened, when it happened, one record each.

use crate::code::code;
use crate::joints::Mode;
use crate::module::ModuleId;
use crate::payload::payload;
use crate::reason::Reason;
use crate::stamp::{Hand, Stamp};
use crate::text::Text;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// What an event is about.
    EventKind as "atas.EventKind.v1" {
        /// A module became active.
        MODULE_ON = 1, "module-on";
        /// A module became inactive.
        MODULE_OFF = 2, "module-off";
        /// A fingertip touched something.
        TOUCH_ON = 3, "touch-on";
        /// A fingertip let go.
        TOUCH_OFF = 4, "touch-off";
        /// A goal changed its state; `value` is the state.
        GOAL = 5, "goal";
        /// A task entered a step; `text` names it.
        STEP = 6, "step";
        /// The mode changed; `reason` says why.
        MODE = 7, "mode";
        /// The stiffness probe ended; `value` is N/m, `text` is F_2.
        STIFFNESS = 8, "stiffness";
        /// Something is wrong but was tolerated; `reason` says what.
        WARNING = 9, "warning";
    }
}

payload! {
    /// One event. Ordered by `stamp.sequence`; a gap means that the queue was full and events were dropped.
    ModuleEvent as "atas.ModuleEvent.v1" {
        /// `captured_ns` is the tick's time.
        pub stamp: Stamp,
        /// The tick.
        pub tick: u64,
        /// What the event is about.
        pub kind: EventKind,
        /// Which module, where one is concerned.
        pub module: ModuleId,
        /// Which hand, where one is concerned.
        pub hand: Hand,
        /// Which finger of the hand, where one is concerned.
        pub finger: u32,
        /// Mode after the event.
        pub mode: Mode,
        /// Written as zero.
        pub pad: u32,
        /// The value that decided, SI units.
        pub value: f64,
        /// The threshold it was held against, SI units.
        pub threshold: f64,
        /// Why, for modes, goals and warnings.
        pub reason: Reason,
        /// A name, where one helps.
        pub text: Text<16>,
    }
}
