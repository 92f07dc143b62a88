//! SIMD lanes: four numbers, and vectors of them, for the bristle computation in
//! [`crate::contact`].
//!
//! * **Use:** contact code is generic over [`Lanes`]; each instruction set implements the trait.
//! * **Invariants:** every lane computes the scalar result without fused operations, and sums over
//!   lanes run in lane order. The instruction set therefore changes no bit. Constructing lanes
//!   requires a `Cpu`, which only feature detection returns.
//! * **Inlining:** a function that is not inlined loses its caller's instruction set. Every hot
//!   function is therefore `inline(always)`; closures are short enough to be inlined.
//! * **Not provided:** wider lanes. Touching bristles lie together in fours, seldom in eights.

use core::ops::{Add, BitAnd, Div, Mul, Sub};

use nalgebra::{Matrix3, Vector3};

#[cfg(target_arch = "x86_64")]
pub(crate) mod avx2;
pub(crate) mod portable;

pub(crate) const LANES: usize = 4;

/// One number per lane, in memory.
pub(crate) type Row = [f64; LANES];

/// x, y and z of one vector per lane, in memory.
pub(crate) type Rows = [Row; 3];

/// One number per lane.
pub(crate) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Proof that this machine has the instructions.
    type Cpu: Copy;
    /// One truth value per lane.
    type Mask: Copy + BitAnd<Output = Self::Mask>;

    fn splat(cpu: Self::Cpu, value: f64) -> Self;
    fn load(cpu: Self::Cpu, row: &Row) -> Self;
    fn store(self) -> Row;
    fn sqrt(self) -> Self;
    fn abs(self) -> Self;
    /// Returns where `self` > `other`; false for NaN.
    fn above(self, other: Self) -> Self::Mask;
    /// Returns where `self` ≤ `other`; false for NaN.
    fn at_most(self, other: Self) -> Self::Mask;
    /// Returns `yes` where the mask is true, otherwise `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Returns the lanes where the mask is true.
    fn set(mask: Self::Mask) -> LaneSet;
}

/// One vector per lane.
#[derive(Clone, Copy)]
pub(crate) struct Vectors<L> {
    pub(crate) x: L,
    pub(crate) y: L,
    pub(crate) z: L,
}

impl<L: Lanes> Vectors<L> {
    #[inline(always)]
    pub(crate) fn splat(cpu: L::Cpu, vector: &Vector3<f64>) -> Self {
        Self {
            x: L::splat(cpu, vector.x),
            y: L::splat(cpu, vector.y),
            z: L::splat(cpu, vector.z),
        }
    }

    #[inline(always)]
    pub(crate) fn load(cpu: L::Cpu, rows: &Rows) -> Self {
        Self {
            x: L::load(cpu, &rows[0]),
            y: L::load(cpu, &rows[1]),
            z: L::load(cpu, &rows[2]),
        }
    }

    #[inline(always)]
    pub(crate) fn store(self) -> Rows {
        [self.x.store(), self.y.store(), self.z.store()]
    }

    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> L {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub(crate) fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    #[inline(always)]
    pub(crate) fn rotated(self, cpu: L::Cpu, by: &Matrix3<f64>) -> Self {
        Self {
            x: self.dot(Self::splat(cpu, &by.row(0).transpose())),
            y: self.dot(Self::splat(cpu, &by.row(1).transpose())),
            z: self.dot(Self::splat(cpu, &by.row(2).transpose())),
        }
    }

    #[inline(always)]
    pub(crate) fn select(mask: L::Mask, yes: Self, no: Self) -> Self {
        Self {
            x: L::select(mask, yes.x, no.x),
            y: L::select(mask, yes.y, no.y),
            z: L::select(mask, yes.z, no.z),
        }
    }
}

macro_rules! by_component {
    ($($trait:ident $method:ident $symbol:tt;)*) => {$(
        impl<L: Lanes> $trait for Vectors<L> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self {
                    x: self.x $symbol other.x,
                    y: self.y $symbol other.y,
                    z: self.z $symbol other.z,
                }
            }
        }
    )*};
}

macro_rules! by_number {
    ($($trait:ident $method:ident $symbol:tt;)*) => {$(
        impl<L: Lanes> $trait<L> for Vectors<L> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: L) -> Self {
                Self {
                    x: self.x $symbol other,
                    y: self.y $symbol other,
                    z: self.z $symbol other,
                }
            }
        }
    )*};
}

by_component! {
    Add add +;
    Sub sub -;
}

by_number! {
    Mul mul *;
    Div div /;
}

#[inline(always)]
pub(crate) fn vector(rows: &Rows, lane: usize) -> Vector3<f64> {
    Vector3::new(rows[0][lane], rows[1][lane], rows[2][lane])
}

/// Set of lanes; iterates in lane order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct LaneSet(u8);

impl LaneSet {
    /// Creates a set from one bit per lane, lane 0 lowest.
    #[inline(always)]
    pub(crate) fn from_bits(bits: u8) -> Self {
        Self(bits)
    }

    #[inline(always)]
    pub(crate) fn union(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    #[inline(always)]
    pub(crate) fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    #[inline(always)]
    pub(crate) fn is_empty(self) -> bool {
        self.0 == 0
    }

    #[inline(always)]
    pub(crate) fn len(self) -> u32 {
        self.0.count_ones()
    }
}

impl Iterator for LaneSet {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros() as usize;
        self.0 &= self.0.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    }
}

#[cfg(test)]
mod tests;
