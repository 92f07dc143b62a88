//! Moving joint of a URDF with its frame.

use urdf_rs::Joint;

use crate::transform::Transform;

/// Moving joint of a URDF with its frame.
pub(super) struct Framed<'a> {
    pub(super) joint: &'a Joint,
    pub(super) frame_from_link: Transform,
    /// Joint of the hand whose coordinate moves it.
    pub(super) driver: usize,
}
