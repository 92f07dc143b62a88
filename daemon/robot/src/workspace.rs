//! Workspace: box over the table to which a robot file limits grasps from above.

/// Box of grasps from above; minimum and maximum of each value, metres.
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
    /// Returns true if every range is finite and ordered.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        [self.x_m, self.y_m, self.z_m, self.opening_m]
            .iter()
            .all(|[least, most]| least.is_finite() && most.is_finite() && least <= most)
    }
}
