//! Grasp sides of a hand's fingertips.

use crate::sizes::{FINGERTIPS_MAX, GRASP_SIDES};

/// Grasp side of each fingertip of a hand. Values of fingertips become values of grasp sides only
/// through this type, because a side may have several fingertips, in any order.
///
/// ```
/// # #[cfg(feature = "std")] {
/// use robot_model::{HandSide, RobotModel};
///
/// let robot = RobotModel::find("three-finger")?;
/// let sides = robot.hand(HandSide::Right).grasp_sides();
/// let normal_n = [1.0, 2.0, 4.0, 0.0];
/// assert_eq!(sides.sums(|fingertip| normal_n[fingertip]), [3.0, 4.0]);
/// # }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GraspSides {
    side: [usize; FINGERTIPS_MAX],
    fingertip_count: usize,
}

impl GraspSides {
    pub(crate) fn new(sides: impl Iterator<Item = usize>) -> Self {
        let mut new = Self {
            side: [0; FINGERTIPS_MAX],
            fingertip_count: 0,
        };
        for (entry, side) in new.side.iter_mut().zip(sides) {
            *entry = side;
            new.fingertip_count += 1;
        }
        new
    }

    /// Returns the number of fingertips.
    #[must_use]
    pub fn fingertip_count(&self) -> usize {
        self.fingertip_count
    }

    /// Returns the sum of a fingertip value per grasp side, such as its normal force.
    pub fn sums(&self, value: impl Fn(usize) -> f64) -> [f64; GRASP_SIDES] {
        let mut sums = [0.0; GRASP_SIDES];
        for (fingertip, side) in self.side[..self.fingertip_count].iter().enumerate() {
            sums[*side] += value(fingertip);
        }
        sums
    }

    /// Returns the smaller of both sides' sums; ignores a sum that is NaN.
    pub fn smaller_sum(&self, value: impl Fn(usize) -> f64) -> f64 {
        self.sums(value).into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Returns the mean of both sides' sums.
    pub fn mean_sum(&self, value: impl Fn(usize) -> f64) -> f64 {
        self.sums(value).iter().sum::<f64>() / GRASP_SIDES as f64
    }

    /// Returns true if both sides' sums exceed a limit; a sum that is NaN does not.
    pub fn both_exceed(&self, limit: f64, value: impl Fn(usize) -> f64) -> bool {
        self.sums(value).iter().all(|sum| *sum > limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_follow_sides_in_any_order() {
        let check = |sides: &[usize], expected: [f64; 2]| {
            let sides = GraspSides::new(sides.iter().copied());
            let values = [1.0, 2.0, 4.0, 8.0];
            assert_eq!(sides.sums(|tip| values[tip]), expected, "{sides:?}");
        };
        check(&[0, 1], [1.0, 2.0]);
        check(&[1, 0], [2.0, 1.0]);
        check(&[0, 0, 1], [3.0, 4.0]);
        check(&[1, 0, 1, 0], [10.0, 5.0]);
        check(&[], [0.0, 0.0]);
    }

    #[test]
    fn both_sides_must_exceed_the_limit() {
        let sides = GraspSides::new([0, 0, 1].into_iter());
        let check = |values: [f64; 3], expected| {
            let exceed = sides.both_exceed(0.5, |tip| values[tip]);
            assert_eq!(exceed, expected, "{values:?}");
        };
        check([1.0, 1.0, 1.0], true);
        check([0.0, 1.0, 1.0], true);
        check([1.0, 1.0, 0.0], false);
        check([1.0, 1.0, f64::NAN], false);
        assert_eq!(sides.smaller_sum(|tip| [1.0, 1.0, 3.0][tip]), 2.0);
        assert_eq!(sides.mean_sum(|tip| [1.0, 1.0, 3.0][tip]), 2.5);
    }
}
