//! The sensor bits that a behaviour table may read, by number.

use crate::code::code;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// One sensor bit of a behaviour table that feels: true or false in every tick (paper Table 1, S1 to S5).
    SensorBit as "atas.SensorBit.v1" {
        /// No bit.
        NONE = 0, "none";
        /// Every finger touches.
        TOUCHING = 1, "touching";
        /// The weakest finger presses more than F_1: what Module 1 asks.
        ABOVE_F1 = 2, "above-f1";
        /// A finger has nearly used up its friction, or slips: what Module 2 asks.
        SLIPPING = 3, "slipping";
        /// The strongest finger presses more than F_2: what Module 3 asks.
        ABOVE_F2 = 4, "above-f2";
        /// The hand has carried its object for more than 3 mm.
        LIFTED = 5, "lifted";
        /// Every finger has had friction to spare for 100 ms.
        SPARE = 6, "spare";
    }
}
