//! Module numbers.

use crate::code::code;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// Modules of the paper and additional modules.
    ModuleId as "atas.ModuleId.v1" {
        /// No module.
        NONE = 0, "none";
        /// Module 0: square trajectory, adapted by contact (paper II.b (2)).
        TRAJECTORY = 1, "module 0, trajectory";
        /// Module 0': moves and places the object (paper II.b (3)).
        TRANSFER = 2, "module 0', transfer";
        /// Module 1: first touch, F_n > F_1 (paper II.b (1)).
        FIRST_TOUCH = 3, "module 1, first touch";
        /// Module 2: slip, dF_t > dr (paper II.b (1)).
        SLIP = 4, "module 2, slip";
        /// Module 3: force limit, F_n > F_2 (paper II.b (1)).
        FORCE_LIMIT = 5, "module 3, force limit";
        /// Module 4: ends screwing, dF_t > 1.4 dF_max (paper II.b (2)).
        TERMINATE_SCREW = 6, "module 4, screw end";
        /// Module 4: releases on upward tangential force (paper II.b (3)).
        RELEASE_PLACED = 7, "module 4, release";
        /// Stiffness probe, 100 ms after the first touch (paper II.b (1)).
        PROBE = 8, "stiffness probe";
        /// Moves the hand along a planned path.
        CARRY = 9, "carry";
        /// Grip relaxation: reduces force that friction does not require.
        RELAX = 10, "relax";
        /// Moves the hand back on contact during free motion.
        CONTACT_GUARD = 11, "contact guard";
        /// Lift verification: one pull-back during the lift distinguishes a suspended object from a
        /// supported one.
        LIFT_VERIFICATION = 12, "lift verification";
        /// Increases the grip by a fixed share on each slip; a baseline, not used by built-in
        /// tasks.
        SLIP_REACTION = 13, "slip reaction";
        /// Teleoperation: tracks streamed targets with limited speed, acceleration and jerk.
        TELEOP = 14, "teleop";
        /// Commands fingers and hand from the behaviour table of the task (paper section III).
        BEHAVIOUR_TABLE = 15, "behaviour table";
    }
}
