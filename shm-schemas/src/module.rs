//! The modules, by number.

use crate::code::code;
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
        /// Stiffness probe, 100 ms after the first touch (paper II.b (1)).
        PROBE = 8, "stiffness probe";
        /// Carries the hand along a planned path.
        CARRY = 9, "carry";
        /// Gives back force that friction does not need.
        RELAX = 10, "relax";
        /// Turns the hand back when it touches something while it moves freely.
        CONTACT_GUARD = 11, "contact guard";
        /// Tugs back once in a lift, to tell what hangs from what still stands.
        LOAD_TEST = 12, "load test";
        /// Grips harder by a fixed share whenever the object slips: a baseline, in no built-in task.
        SLIP_REACTION = 13, "slip reaction";
        /// Leads the hand after streamed targets, within limits of speed, acceleration and jerk.
        FOLLOW = 14, "follow";
        /// Reads fingers and hand off the task's behaviour table (paper section III).
        BEHAVIOUR_TABLE = 15, "behaviour table";
    }
}
