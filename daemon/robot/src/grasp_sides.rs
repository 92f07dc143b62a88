//! Grasp sides: their names, one value per side, and the side of each fingertip of a hand.

use core::ops::{Index, IndexMut};

use crate::sizes::{FINGERTIPS_MAX, GRASP_SIDES};

/// Side of a grasp (the literature's *virtual finger*): fingertips that press in one direction. A
/// grasp has two opposing sides. Robot files and messages call them 1 and 2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum GraspSide {
    /// Side 1 of the robot file.
    #[default]
    First,
    /// Side 2 of the robot file.
    Second,
}

impl GraspSide {
    /// Both sides.
    pub const BOTH: [Self; GRASP_SIDES] = [Self::First, Self::Second];

    /// Returns the index for messages: 0 or 1.
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }

    /// Returns the sign of the side's outward direction along the closing axis: 1 or −1.
    #[must_use]
    pub fn outward(self) -> f64 {
        match self {
            Self::First => 1.0,
            Self::Second => -1.0,
        }
    }

    /// Returns the other side.
    #[must_use]
    pub fn opposite(self) -> Self {
        match self {
            Self::First => Self::Second,
            Self::Second => Self::First,
        }
    }
}

/// One value per grasp side. Only a [`GraspSide`] indexes it, so that the index of a fingertip
/// cannot.
///
/// ```
/// use robot_model::{GraspSide, PerSide};
///
/// let mut normal_n = PerSide::new(1.0, 2.0);
/// normal_n[GraspSide::Second] += 1.0;
/// assert_eq!(normal_n.map(|n| n * 2.0), PerSide::new(2.0, 6.0));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PerSide<T>([T; GRASP_SIDES]);

impl<T> PerSide<T> {
    /// Creates the values of the first and the second side.
    pub const fn new(first: T, second: T) -> Self {
        Self([first, second])
    }

    /// Creates each value from its side.
    pub fn from_fn(value: impl FnMut(GraspSide) -> T) -> Self {
        Self(GraspSide::BOTH.map(value))
    }

    /// Applies a function to each value.
    pub fn map<U>(self, function: impl FnMut(T) -> U) -> PerSide<U> {
        PerSide(self.0.map(function))
    }

    /// Combines each value with that of the same side of `other`.
    pub fn zip_map<U, V>(
        self,
        other: PerSide<U>,
        mut function: impl FnMut(T, U) -> V,
    ) -> PerSide<V> {
        let [first, second] = self.0;
        let [other_first, other_second] = other.0;
        PerSide([function(first, other_first), function(second, other_second)])
    }

    /// Returns references to the values.
    pub fn each_ref(&self) -> PerSide<&T> {
        PerSide(self.0.each_ref())
    }

    /// Returns each side with its value.
    pub fn entries(&self) -> impl Iterator<Item = (GraspSide, &T)> {
        GraspSide::BOTH.into_iter().zip(&self.0)
    }

    /// Returns the values, first side first.
    pub fn iter(&self) -> core::slice::Iter<'_, T> {
        self.0.iter()
    }

    /// Returns the values for modification, first side first.
    pub fn iter_mut(&mut self) -> core::slice::IterMut<'_, T> {
        self.0.iter_mut()
    }

    /// Returns the values as an array for messages, first side first.
    pub fn into_array(self) -> [T; GRASP_SIDES] {
        self.0
    }
}

impl PerSide<f64> {
    /// Returns the mean of both sides.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / GRASP_SIDES as f64
    }
}

impl<T: Copy> PerSide<T> {
    /// Creates the same value for both sides.
    pub const fn repeat(value: T) -> Self {
        Self([value; GRASP_SIDES])
    }
}

impl<T> From<[T; GRASP_SIDES]> for PerSide<T> {
    fn from(values: [T; GRASP_SIDES]) -> Self {
        Self(values)
    }
}

impl<T> Index<GraspSide> for PerSide<T> {
    type Output = T;

    fn index(&self, side: GraspSide) -> &T {
        &self.0[side.index()]
    }
}

impl<T> IndexMut<GraspSide> for PerSide<T> {
    fn index_mut(&mut self, side: GraspSide) -> &mut T {
        &mut self.0[side.index()]
    }
}

impl<T> IntoIterator for PerSide<T> {
    type Item = T;
    type IntoIter = core::array::IntoIter<T, GRASP_SIDES>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl<'a, T> IntoIterator for &'a PerSide<T> {
    type Item = &'a T;
    type IntoIter = core::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl<'a, T> IntoIterator for &'a mut PerSide<T> {
    type Item = &'a mut T;
    type IntoIter = core::slice::IterMut<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter_mut()
    }
}

/// Grasp side of each fingertip of a hand. Values of fingertips become values of grasp sides only
/// through this type, because a side may have several fingertips, in any order.
///
/// ```
/// # #[cfg(feature = "std")] {
/// use robot_model::{HandSide, PerSide, RobotModel};
///
/// let robot = RobotModel::find("three-finger")?;
/// let sides = robot.hand(HandSide::Right).grasp_sides();
/// let normal_n = [1.0, 2.0, 4.0, 0.0];
/// assert_eq!(sides.sums(|fingertip| normal_n[fingertip]), PerSide::new(3.0, 4.0));
/// # }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GraspSides {
    side: [GraspSide; FINGERTIPS_MAX],
    fingertip_count: usize,
}

impl GraspSides {
    pub(crate) fn new(sides: impl Iterator<Item = GraspSide>) -> Self {
        let mut new = Self {
            side: [GraspSide::First; FINGERTIPS_MAX],
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
    pub fn sums(&self, value: impl Fn(usize) -> f64) -> PerSide<f64> {
        let mut sums = PerSide::default();
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
        self.sums(value).mean()
    }

    /// Returns true if both sides' sums exceed a limit; a sum that is NaN does not.
    pub fn both_exceed(&self, limit: f64, value: impl Fn(usize) -> f64) -> bool {
        self.sums(value).iter().all(|sum| *sum > limit)
    }
}

#[cfg(test)]
mod tests {
    use super::GraspSide::{First, Second};
    use super::*;

    #[test]
    fn sums_follow_sides_in_any_order() {
        let check = |sides: &[GraspSide], expected: [f64; 2]| {
            let sides = GraspSides::new(sides.iter().copied());
            let values = [1.0, 2.0, 4.0, 8.0];
            assert_eq!(sides.sums(|tip| values[tip]), expected.into(), "{sides:?}");
        };
        check(&[First, Second], [1.0, 2.0]);
        check(&[Second, First], [2.0, 1.0]);
        check(&[First, First, Second], [3.0, 4.0]);
        check(&[Second, First, Second, First], [10.0, 5.0]);
        check(&[], [0.0, 0.0]);
    }

    #[test]
    fn both_sides_must_exceed_the_limit() {
        let sides = GraspSides::new([First, First, Second].into_iter());
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
