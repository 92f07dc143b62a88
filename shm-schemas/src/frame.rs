//! Tactile frames.

use crate::capacity::{ELEMENTS, FINGERS};
use crate::payload::payload;
use crate::stamp::{Hand, Stamp};
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
use zerocopy::IntoBytes;

payload! {
    /// Tactile frame: readings of all fingertips of one hand.
    ///
    /// Forces act from the object **on** the fingertip, resolved along the axes of each element:
    /// `f_n = −F·d` (positive under pressure), `f_t1 = F·t1`, `f_t2 = F·t2`. The axes d, t1, t2
    /// come from the [`crate::Layout`] that both sides configure; [`HandFrame::layout_hash`]
    /// verifies that the layouts match.
    HandFrame as "atas.HandFrame.v1" {
        /// `captured_ns` is the sampling time of the sensor.
        pub stamp: Stamp,
        /// [`crate::Layout::hash`] of the element layout.
        pub layout_hash: u64,
        /// Hand of the sensors.
        pub hand: Hand,
        /// Number of fingertips with data, at most [`FINGERS`]. Fingertip 0 is `finger1` of the
        /// URDF.
        pub finger_count: u32,
        /// Per fingertip: bit e is set if the reading of element e is valid.
        pub valid_mask: [u64; FINGERS],
        /// Forces, N: `force_n[finger][element] = [f_n, f_t1, f_t2]`.
        pub force_n: [[[f32; 3]; ELEMENTS]; FINGERS],
        /// Written as zero.
        pub pad: u32,
        /// CRC-32 (IEEE) of every byte before this field; see [`HandFrame::seal`].
        pub crc32: u32,
    }
}

crate::crc::sealed!(HandFrame);
