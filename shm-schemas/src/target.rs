//! Targets: where a client that streams wants a hand to be, and what its fingers shall do.

use crate::code::code;
use crate::payload::payload;
use crate::stamp::{Hand, Stamp};
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
use zerocopy::IntoBytes;

code! {
    /// What the fingers shall do.
    GripOrder as "atas.GripOrder.v1" {
        /// Go to `opening_m`. Fingertips that meet something on their way take hold of it, and hold it as gently as touch
        /// allows, until a wider opening is wanted.
        WIDTH = 0, "width";
        /// Close until the fingertips touch, and hold what is there.
        HOLD = 1, "hold";
    }
}

payload! {
    /// Where a hand shall be: one target of the stream that a goal `follow` has opened. Frame: base of the robot (x forward,
    /// y left, z up, origin on the table top under the torso); the hand points straight down.
    ///
    /// The newest target counts. The hand follows it within limits of its own; how hard it holds is not the client's to say.
    GraspTarget as "atas.GraspTarget.v1" {
        /// `writer_epoch` is that of the goal's request, `sequence` rises, `captured_ns` is when the target was made.
        pub stamp: Stamp,
        /// The hand stops and keeps what it holds if nothing newer has come by then, nanoseconds of the clock of the daemon's
        /// stamps. At most two seconds ahead count.
        pub valid_until_ns: u64,
        /// Which hand.
        pub hand: Hand,
        /// What its fingers shall do.
        pub grip: GripOrder,
        /// Point between the fingertips, m.
        pub centre_m: [f64; 3],
        /// Direction of the closing axis, rad from +x towards +y. A half turn more or less is the same grasp: the hand takes
        /// the one that is nearer.
        pub closing_yaw_rad: f64,
        /// Distance between the fingertips' surfaces, m; not used by HOLD.
        pub opening_m: f64,
        /// Written as zero.
        pub pad: u32,
        /// CRC-32 (IEEE) of every byte before this field.
        pub crc32: u32,
    }
}

crate::crc::sealed!(GraspTarget);

impl GraspTarget {
    /// Names of [`GraspTarget::values`], in order; a [`crate::Reason`] about a target refers to them by index.
    pub const VALUE_NAMES: [&'static str; 5] = ["x", "y", "z", "yaw", "opening"];

    /// Every number of the target, in the order of [`GraspTarget::VALUE_NAMES`], SI units.
    #[must_use]
    pub fn values(&self) -> [f64; 5] {
        let [x, y, z] = self.centre_m;
        [x, y, z, self.closing_yaw_rad, self.opening_m]
    }
}
