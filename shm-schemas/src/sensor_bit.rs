//! Sensor bits that a behaviour table can read.

use crate::code::code;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// Sensor bit of a behaviour table, evaluated in every tick (paper Table 1, S1 to S5).
    SensorBit as "atas.SensorBit.v1" {
        /// No bit.
        NONE = 0, "none";
        /// Every fingertip is in contact.
        TOUCHING = 1, "touching";
        /// The lowest normal force exceeds F_1 (condition of Module 1).
        ABOVE_F1 = 2, "above-f1";
        /// The friction utilisation of a fingertip is close to 1, or it slips (condition of Module
        /// 2).
        SLIPPING = 3, "slipping";
        /// The highest normal force exceeds F_2 (condition of Module 3).
        ABOVE_F2 = 4, "above-f2";
        /// The hand has lifted the object by more than 3 mm.
        LIFTED = 5, "lifted";
        /// Every fingertip has had a friction margin for 100 ms.
        FRICTION_MARGIN = 6, "friction-margin";
    }
}
