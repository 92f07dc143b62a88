//! Wire formats of real sensors, one file each: bytes in, decoded frames and counts out.
//!
//! Nothing here reads a clock, opens a device or allocates per frame, so property tests can hammer all of it.

pub mod continuity;
pub mod optoforce;
