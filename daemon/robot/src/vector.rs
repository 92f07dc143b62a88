//! Vectors with one value per joint, in fixed memory; they dereference to a slice of the used
//! values.

use core::ops::{Add, AddAssign, Deref, DerefMut, Mul, Sub};

use crate::sizes::{HAND_JOINTS_MAX, ROBOT_JOINTS_MAX};

/// One value per joint of a hand, in the hand's order.
pub type HandVector = JointVector<HAND_JOINTS_MAX>;
/// One value per joint of the robot: left hand, then right hand.
pub type RobotVector = JointVector<ROBOT_JOINTS_MAX>;

/// Up to `MAX` values.
///
/// Units of the joint: positions in radians for a revolute joint and in metres for a prismatic one,
/// velocities in rad/s or m/s, efforts in N·m or N.
///
/// ```
/// use robot_model::HandVector;
///
/// let step = HandVector::repeat(3, 0.01);
/// let q = HandVector::zeros(3) + step * 2.0;
/// assert_eq!(&q[..], [0.02; 3]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointVector<const MAX: usize> {
    /// Zero beyond `count`.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    values: [f64; MAX],
    count: usize,
}

impl<const MAX: usize> JointVector<MAX> {
    /// Vector of a robot without joints.
    pub(crate) const NONE: Self = Self {
        values: [0.0; MAX],
        count: 0,
    };

    /// Creates `count` values, each from its index; at most `MAX`.
    pub fn from_fn(count: usize, mut value: impl FnMut(usize) -> f64) -> Self {
        let mut values = [0.0; MAX];
        let count = count.min(MAX);
        for (joint, slot) in values[..count].iter_mut().enumerate() {
            *slot = value(joint);
        }
        Self { values, count }
    }

    /// Creates a vector of `count` equal values.
    #[must_use]
    pub fn repeat(count: usize, value: f64) -> Self {
        Self::from_fn(count, |_| value)
    }

    /// Creates a vector of `count` zeros.
    #[must_use]
    pub fn zeros(count: usize) -> Self {
        Self::repeat(count, 0.0)
    }

    /// Copies a slice, at most the first `MAX` values.
    #[must_use]
    pub fn from_slice(values: &[f64]) -> Self {
        Self::from_fn(values.len(), |joint| values[joint])
    }

    /// Applies a function to each value.
    #[must_use]
    pub fn map(&self, mut of: impl FnMut(f64) -> f64) -> Self {
        Self::from_fn(self.count, |joint| of(self[joint]))
    }

    /// Combines each value with that of the same joint of `other`; the shorter length counts.
    #[must_use]
    pub fn zip_map(&self, other: &Self, mut of: impl FnMut(f64, f64) -> f64) -> Self {
        let count = self.count.min(other.count);
        Self::from_fn(count, |joint| of(self[joint], other[joint]))
    }

    /// Returns the largest absolute value.
    #[must_use]
    pub fn amax(&self) -> f64 {
        self.iter()
            .fold(0.0, |most: f64, value| most.max(value.abs()))
    }
}

impl<const MAX: usize> Default for JointVector<MAX> {
    /// Vector of a robot without joints.
    fn default() -> Self {
        Self::NONE
    }
}

impl<const MAX: usize, const N: usize> From<[f64; N]> for JointVector<MAX> {
    fn from(values: [f64; N]) -> Self {
        const { assert!(N <= MAX) };
        Self::from_slice(&values)
    }
}

impl<const MAX: usize> Deref for JointVector<MAX> {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        self.values.get(..self.count).unwrap_or_default()
    }
}

impl<const MAX: usize> DerefMut for JointVector<MAX> {
    fn deref_mut(&mut self) -> &mut [f64] {
        self.values.get_mut(..self.count).unwrap_or_default()
    }
}

impl<const MAX: usize> Add for JointVector<MAX> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        self.zip_map(&other, |a, b| a + b)
    }
}

impl<const MAX: usize> Sub for JointVector<MAX> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self.zip_map(&other, |a, b| a - b)
    }
}

impl<const MAX: usize> Mul<f64> for JointVector<MAX> {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        self.map(|value| value * factor)
    }
}

impl<const MAX: usize> AddAssign for JointVector<MAX> {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
