//! Teleoperation targets: hand pose and grip command, streamed by a client.

use crate::code::code;
use crate::payload::payload;
use crate::stamp::{Hand, Stamp};
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
use zerocopy::IntoBytes;

code! {
    /// Grip command of a target.
    GripOrder as "atas.GripOrder.v1" {
        /// Moves to `opening_m`. On contact the fingertips hold the object with the minimum force,
        /// until a wider opening is commanded.
        WIDTH = 0, "width";
        /// Closes until contact and holds the object.
        HOLD = 1, "hold";
    }
}

payload! {
    /// Target of one hand in the stream of a goal `teleop`. Frame: robot base (x forward, y left, z
    /// up, origin on the table top under the torso); the hand points straight down.
    ///
    /// The newest target replaces older ones. The hand tracks it within the daemon's own limits;
    /// the controller alone determines the grip force.
    GraspTarget as "atas.GraspTarget.v1" {
        /// `writer_epoch` is that of the goal request, `sequence` increases, `captured_ns` is the
        /// creation time of the target.
        pub stamp: Stamp,
        /// End of validity, ns of the daemon's clock, effective up to two seconds ahead. Without a
        /// newer target the hand then stops and keeps its grip.
        pub valid_until_ns: u64,
        /// Hand to move.
        pub hand: Hand,
        /// Grip command.
        pub grip: GripOrder,
        /// Point between the fingertips, m.
        pub centre_m: [f64; 3],
        /// Direction of the closing axis, rad from +x towards +y. Directions half a turn apart are
        /// the same grasp; the hand takes the nearer one.
        pub closing_yaw_rad: f64,
        /// Distance between the fingertip surfaces, m; not used by HOLD.
        pub opening_m: f64,
        /// Written as zero.
        pub pad: u32,
        /// CRC-32 (IEEE) of every byte before this field.
        pub crc32: u32,
    }
}

crate::crc::sealed!(GraspTarget);

impl GraspTarget {
    /// Names of [`GraspTarget::values`], in order. [`crate::TargetField`] is the index of
    /// a name.
    pub const VALUE_NAMES: [&'static str; 5] = ["x", "y", "z", "yaw", "opening"];

    /// Returns all numbers of the target, in the order of [`GraspTarget::VALUE_NAMES`], SI units.
    #[must_use]
    pub fn values(&self) -> [f64; 5] {
        let [x, y, z] = self.centre_m;
        [x, y, z, self.closing_yaw_rad, self.opening_m]
    }
}
