//! SIMD lanes: one trial per lane.
//!
//! [`stream`] assigns trials to lanes. [`kernel`] is the model, written over [`Lanes`]. Each
//! instruction set implements [`Lanes`]; [`twice`] combines two registers.
//!
//! Invariant: a lane value exists only if the processor has its instructions. Every constructor
//! takes a `Cpu`, which only detection returns; this makes the safe operators sound.

#[cfg(target_arch = "x86_64")]
pub(crate) mod avx2;
#[cfg(target_arch = "x86_64")]
pub(crate) mod avx512;
mod inputs;
mod kernel;
pub(crate) mod portable;
mod results;
pub(crate) mod stream;
#[cfg(target_arch = "x86_64")]
pub(crate) mod twice;

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Sub};

pub(crate) trait Vector: Copy {
    /// Number of lanes.
    const WIDTH: usize;
}

pub(crate) trait Mask: Vector + BitAnd<Output = Self> + BitOr<Output = Self> {
    /// One bit per lane, lane 0 lowest.
    fn bits(self) -> u32;
    fn any(self) -> bool;
    fn all(self) -> bool;
}

/// Integers; arithmetic wraps.
pub(crate) trait Ints:
    Vector + Add<Output = Self> + BitAnd<Output = Self> + BitOr<Output = Self> + BitXor<Output = Self>
{
    /// Shifts by each lane's count, below 32.
    fn shl(self, count: Self) -> Self;
    /// Logical shift by each lane's count, below 32.
    fn shr(self, count: Self) -> Self;
    /// Returns 1 shifted left by each count, below 32.
    fn bit(self) -> Self;
    /// Writes `WIDTH` values.
    fn store(self, to: &mut [i32]);
}

/// Numbers; operations round like their scalar counterparts.
pub(crate) trait Lanes:
    Vector + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Proof of the instructions.
    type Cpu: Copy;
    type Mask: Mask;
    type Ints: Ints;
    /// False if a value is an array.
    const REGISTERS: bool;

    fn splat(cpu: Self::Cpu, value: f32) -> Self;
    /// Reads `WIDTH` values.
    fn load(cpu: Self::Cpu, from: &[f32]) -> Self;
    /// Writes `WIDTH` values.
    fn store(self, to: &mut [f32]);
    fn sqrt(self) -> Self;
    fn max_abs(self, other: Self) -> Self;
    /// Clamps to ± `limit` (above 0).
    fn clamp(self, limit: Self) -> Self;
    /// `self > other ? self : other`
    fn max(self, other: Self) -> Self;
    fn lt(self, other: Self) -> Self::Mask;
    /// `self < other`, only in the lanes of the mask.
    #[inline(always)]
    fn lt_among(self, other: Self, lanes: Self::Mask) -> Self::Mask {
        lanes & self.lt(other)
    }
    fn eq(self, other: Self) -> Self::Mask;
    /// `mask ? yes : no`
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// Mask with these [`Mask::bits`].
    fn mask(cpu: Self::Cpu, bits: u32) -> Self::Mask;
    fn int_splat(cpu: Self::Cpu, value: i32) -> Self::Ints;
    /// Reads `WIDTH` values.
    fn int_load(cpu: Self::Cpu, from: &[i32]) -> Self::Ints;
    fn int_select(mask: Self::Mask, yes: Self::Ints, no: Self::Ints) -> Self::Ints;
    fn is_zero(value: Self::Ints) -> Self::Mask;

    /// Uses the lowest six bits.
    fn cos_sin(heading: Self::Ints) -> (Self, Self);
    /// Turn (right − left level) and travel of a code's lowest four bits.
    fn drive(code: Self::Ints, travel: &[f32; 16]) -> (Self::Ints, Self);
}

/// Right − left level by code (left + 4 · right).
static TURN: [i32; 16] = {
    let mut turn = [0; 16];
    let mut code = 0;
    while code < 16 {
        turn[code] = (code as i32 >> 2) - (code as i32 & 3);
        code += 1;
    }
    turn
};
