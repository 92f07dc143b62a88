//! The box over the table in which every grasp from above is proved to have a posture.

use core::fmt;

use nalgebra::Vector3;

use crate::side::Side;

/// A box of grasps from above, for the right hand; the left hand's is its mirror image in y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Workspace {
    /// Least and greatest x of the grasp's centre, base frame, metres.
    pub x_m: [f64; 2],
    /// Least and greatest y of the grasp's centre for the right hand, base frame, metres.
    pub right_y_m: [f64; 2],
    /// Least and greatest height of the grasp's centre above the table, metres.
    pub z_m: [f64; 2],
    /// Least and greatest distance between the poles of the two domes, metres.
    pub opening_m: [f64; 2],
}

impl Workspace {
    /// The built-in robot's. Source: each of 274,560 grasps on a grid over this box (2 cm × 3 cm × 26 mm, openings
    /// every 10 mm from 10 mm up, yaws every 15°, both hands) has a posture, at worst 1.3 nm and 0.092° off; a
    /// subsample is solved in this crate's tests. Ours.
    pub const TWO_HAND_ARM: Workspace = Workspace {
        x_m: [0.22, 0.40],
        right_y_m: [-0.30, 0.06],
        z_m: [0.025, 0.21],
        opening_m: [0.02, 0.11],
    };

    /// Whether a grasp from above lies inside.
    ///
    /// # Errors
    /// [`ReachError`] naming the first quantity that is outside or not finite.
    pub fn reach(
        &self,
        side: Side,
        centre_m: &Vector3<f64>,
        opening_m: f64,
    ) -> Result<(), ReachError> {
        let [near, far] = self.right_y_m;
        let y_m = match side {
            Side::Right => [near, far],
            Side::Left => [-far, -near],
        };
        let checks = [
            ("x of the grasp", centre_m.x, self.x_m),
            ("y of the grasp", centre_m.y, y_m),
            ("height of the grasp", centre_m.z, self.z_m),
            ("opening", opening_m, self.opening_m),
        ];
        for (quantity, value_m, [least_m, most_m]) in checks {
            // Written so that NaN is outside.
            if !(value_m >= least_m && value_m <= most_m) {
                return Err(ReachError {
                    side,
                    quantity,
                    value_m,
                    least_m,
                    most_m,
                });
            }
        }
        Ok(())
    }
}

/// A grasp outside the proved workspace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReachError {
    /// The hand that was asked.
    pub side: Side,
    /// What was outside.
    pub quantity: &'static str,
    /// Its value, metres.
    pub value_m: f64,
    /// The least allowed value, metres.
    pub least_m: f64,
    /// The greatest allowed value, metres.
    pub most_m: f64,
}

impl fmt::Display for ReachError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "could not plan the {:?} hand's grasp because {} was {} m, needs {} to {} m; move the object or use the \
             other hand",
            self.side, self.quantity, self.value_m, self.least_m, self.most_m,
        )
    }
}

impl core::error::Error for ReachError {}
