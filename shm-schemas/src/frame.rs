//! What one hand's fingertips feel.

use crate::capacity::{ELEMENTS, FINGERS};
use crate::payload::payload;
use crate::stamp::{Hand, Stamp};
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
use zerocopy::IntoBytes;

payload! {
    /// One reading of all fingertips of one hand.
    ///
    /// Forces are those of the object **on** the tip, resolved along each element's own axes: `f_n = −F·d` (positive
    /// when pressed), `f_t1 = F·t1`, `f_t2 = F·t2`. The axes d, t1, t2 come from the [`crate::Layout`] that both
    /// sides are configured with; [`HandFrame::layout_hash`] proves that they agree.
    HandFrame as "atas.HandFrame.v1" {
        /// `captured_ns` is when the sensor sampled.
        pub stamp: Stamp,
        /// [`crate::Layout::hash`] of the layout that the elements follow.
        pub layout_hash: u64,
        /// Which hand.
        pub hand: Hand,
        /// Fingers that carry data, at most [`FINGERS`]. Finger 0 is `finger1` of the URDF.
        pub finger_count: u32,
        /// Per finger, bit e set: element e carries a valid reading.
        pub valid_mask: [u64; FINGERS],
        /// Newtons: `force_n[finger][element] = [f_n, f_t1, f_t2]`.
        pub force_n: [[[f32; 3]; ELEMENTS]; FINGERS],
        /// Written as zero.
        pub pad: u32,
        /// CRC-32 (IEEE) of every byte before this field: [`HandFrame::seal`], [`HandFrame::is_intact`].
        pub crc32: u32,
    }
}

crate::crc::sealed!(HandFrame);
