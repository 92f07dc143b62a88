//! Forces of a whole hand, from the percept of its sides and fingertips.

use super::Percept;
use nalgebra::Vector3;
use robot_model::Transform;

impl Percept {
    /// Returns the smallest and largest normal force over the grasp sides, N.
    #[must_use]
    pub fn normal_range_n(&self) -> (f64, f64) {
        let [first_n, second_n] = self.sides.each_ref().map(|side| side.normal_n).into_array();
        if first_n < second_n {
            (first_n, second_n)
        } else {
            (second_n, first_n)
        }
    }

    /// Returns the mean normal force of the grasp sides, N.
    #[must_use]
    pub fn mean_normal_n(&self) -> f64 {
        self.sides.each_ref().map(|side| side.normal_n).mean()
    }

    /// Returns the sum of the normal forces of the grasp sides, N.
    #[must_use]
    pub fn total_normal_n(&self) -> f64 {
        self.sides.iter().map(|side| side.normal_n).sum()
    }

    /// Returns the sum of the tangential forces of the grasp sides, N. It includes the shear
    /// between misaligned faces.
    #[must_use]
    pub fn total_tangential_n(&self) -> f64 {
        self.sides.iter().map(|side| side.tangential_n).sum()
    }

    /// Returns the sum of the forces of the object on all fingertips, base frame, N. Input:
    /// measured frame of each fingertip.
    #[must_use]
    pub fn net_force_n(&self, base_from_tip: &[Transform]) -> Vector3<f64> {
        let fingertips = self.fingertips.iter().zip(base_from_tip);
        fingertips
            .map(|(fingertip, base_from_tip)| base_from_tip.rotation * fingertip.force_tip_n)
            .sum()
    }

    /// Returns the vertical force of the object on all fingertips, base frame, N; negative for a
    /// suspended object.
    #[must_use]
    pub fn force_up_n(&self, base_from_tip: &[Transform]) -> f64 {
        self.net_force_n(base_from_tip).z
    }
}
