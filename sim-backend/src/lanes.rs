//! Four numbers side by side, and vectors of them: what the bristles of a fingertip are computed in.
//!
//! * **Who calls:** [`crate::contact`], written once over [`Lanes`]; each instruction set implements that with its own registers.
//! * **Invariants:** every lane computes what a scalar would, nothing is fused, and what is summed over lanes is summed in their
//!   order: the instruction set changes no bit. Lanes exist only where their instructions do: whoever makes some shows a `Cpu`,
//!   which only detection hands out.
//! * **What to know:** what is not inlined knows nothing of its caller's instructions: in what is hot every function is, and closures
//!   are too short not to be.
//! * **Absent on purpose:** wider ones. Bristles that touch lie together in fours, seldom in eights.

use core::ops::{Add, BitAnd, Div, Mul, Sub};

use nalgebra::{Matrix3, Vector3};

#[cfg(target_arch = "x86_64")]
pub(crate) mod avx2;
pub(crate) mod portable;

/// How many.
pub(crate) const LANES: usize = 4;

/// A number per lane, in memory.
pub(crate) type Row = [f64; LANES];

/// x, y and z of a vector per lane, in memory.
pub(crate) type Rows = [Row; 3];

/// A number per lane.
pub(crate) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Proof that this machine has the instructions.
    type Cpu: Copy;
    /// A truth value per lane.
    type Mask: Copy + BitAnd<Output = Self::Mask>;

    fn splat(cpu: Self::Cpu, value: f64) -> Self;
    fn load(cpu: Self::Cpu, row: &Row) -> Self;
    fn store(self) -> Row;
    fn sqrt(self) -> Self;
    fn abs(self) -> Self;
    /// Where this is greater than the other; never where one is not a number.
    fn above(self, other: Self) -> Self::Mask;
    /// Where this is not greater than the other; never where one is not a number.
    fn at_most(self, other: Self) -> Self::Mask;
    /// `yes` where the mask is true.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// The lanes where the mask is true.
    fn set(mask: Self::Mask) -> LaneSet;
}

/// A vector per lane.
#[derive(Clone, Copy)]
pub(crate) struct Vectors<L> {
    pub(crate) x: L,
    pub(crate) y: L,
    pub(crate) z: L,
}

impl<L: Lanes> Vectors<L> {
    /// The same in every lane.
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

    /// Turned by a matrix.
    #[inline(always)]
    pub(crate) fn turned(self, cpu: L::Cpu, by: &Matrix3<f64>) -> Self {
        Self {
            x: self.dot(Self::splat(cpu, &by.row(0).transpose())),
            y: self.dot(Self::splat(cpu, &by.row(1).transpose())),
            z: self.dot(Self::splat(cpu, &by.row(2).transpose())),
        }
    }

    /// `yes` where the mask is true.
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

/// The vector of one lane.
#[inline(always)]
pub(crate) fn vector(rows: &Rows, lane: usize) -> Vector3<f64> {
    Vector3::new(rows[0][lane], rows[1][lane], rows[2][lane])
}

/// Some of the lanes; goes through them in their order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct LaneSet(u8);

impl LaneSet {
    /// From a bit per lane, lane 0 lowest.
    #[inline(always)]
    pub(crate) fn of_bits(bits: u8) -> Self {
        Self(bits)
    }

    /// Those that are in both.
    #[inline(always)]
    pub(crate) fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Those that are not in the other.
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
