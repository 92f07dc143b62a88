//! The box over the table that a robot file keeps grasps from above to.

/// A box of grasps from above, each value's least and greatest, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Workspace {
    /// x of the grasp's centre, base frame.
    pub x_m: [f64; 2],
    /// y of the grasp's centre.
    pub y_m: [f64; 2],
    /// Height of the grasp's centre above the table.
    pub z_m: [f64; 2],
    /// Distance between the poles of the domes.
    pub opening_m: [f64; 2],
}

impl Workspace {
    /// Whether every range is one of numbers, the least first.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        [self.x_m, self.y_m, self.z_m, self.opening_m]
            .iter()
            .all(|[least, most]| least.is_finite() && most.is_finite() && least <= most)
    }
}
