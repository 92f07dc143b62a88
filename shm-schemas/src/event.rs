//! Events: what happened, when it happened, one record each.

use crate::code::code;
use crate::service::word;
use crate::{Hand, Mode, Reason, Stamp, Text};
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// The modules of the paper, and the motions that carry them.
    ModuleId as "atas.ModuleId.v1" {
        /// No module.
        NONE = 0, "none";
        /// Module 0: square trajectory, adapted by contact (paper II.b (2)).
        TRAJECTORY = 1, "module 0, trajectory";
        /// Module 0': conveys and sets down (paper II.b (3)).
        TRANSFER = 2, "module 0', transfer";
        /// Module 1: first touch, F_n > F_1 (paper II.b (1)).
        FIRST_TOUCH = 3, "module 1, first touch";
        /// Module 2: slip, dF_t > dr (paper II.b (1)).
        SLIP = 4, "module 2, slip";
        /// Module 3: force limit, F_n > F_2 (paper II.b (1)).
        FORCE_LIMIT = 5, "module 3, force limit";
        /// Module 4: terminates screwing, dF_t > 1.4 dF_max (paper II.b (2)).
        TERMINATE_SCREW = 6, "module 4, screw end";
        /// Module 4: releases on upward tangential force (paper II.b (3)).
        RELEASE_PLACED = 7, "module 4, release";
        /// Hardness probe, 100 ms after the first touch (paper II.b (1)).
        PROBE = 8, "hardness probe";
        /// Carries the hand along a planned path.
        CARRY = 9, "carry";
        /// Gives back force that friction does not need.
        RELAX = 10, "relax";
        /// Turns the hand back when it touches something while it moves freely.
        GUARD = 11, "touch guard";
        /// Tugs back once in a lift, to tell what hangs from what still stands.
        LIFT_PROOF = 12, "lift proof";
        /// Grips harder by a fixed share whenever the object slips: a baseline, in no built-in task.
        SLIP_REACTION = 13, "slip reaction";
    }
}

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
        /// The hardness probe ended; `value` is N/m, `text` is F_2.
        HARDNESS = 8, "hardness";
        /// Something is wrong but was tolerated; `reason` says what.
        WARNING = 9, "warning";
    }
}

word! {
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
