//! SIMD lanes: one trial per lane.
//!
//! [`stream`] leads trials through the lanes; [`kernel`] is the model, written once over [`Lanes`]; each instruction set
//! implements [`Lanes`] with its own registers, and [`twice`] puts two of them side by side.
//! A value of a lane type exists only where its instruction set does: every constructor asks for the type's `Cpu`, a proof
//! that only detection hands out. That is what makes the intrinsics behind the safe operators sound.

#[cfg(target_arch = "x86_64")]
pub(crate) mod avx2;
#[cfg(target_arch = "x86_64")]
pub(crate) mod avx512;
mod kernel;
pub(crate) mod portable;
mod results;
mod seats;
pub(crate) mod stream;
#[cfg(target_arch = "x86_64")]
pub(crate) mod twice;

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Sub};

/// A value per lane.
pub(crate) trait Vector: Copy {
    /// Lanes: trials side by side.
    const WIDTH: usize;
}

/// A truth value per lane.
pub(crate) trait Mask: Vector + BitAnd<Output = Self> + BitOr<Output = Self> {
    /// One bit per lane, lane 0 lowest.
    fn bits(self) -> u32;
    /// Whether any lane is true.
    fn any(self) -> bool;
    /// Whether every lane is true.
    fn all(self) -> bool;
}

/// An integer per lane; arithmetic wraps.
pub(crate) trait Ints:
    Vector + Add<Output = Self> + BitAnd<Output = Self> + BitOr<Output = Self> + BitXor<Output = Self>
{
    /// Each lane shifted left by its own count, below 32; zeros come in.
    fn shl(self, count: Self) -> Self;
    /// Each lane shifted right by its own count, below 32; zeros come in.
    fn shr(self, count: Self) -> Self;
    /// 1 shifted left by each lane's count, below 32.
    fn bit(self) -> Self;
    /// Writes `WIDTH` values.
    fn store(self, to: &mut [i32]);
}

/// A number per lane. Every operation rounds as its scalar counterpart does.
pub(crate) trait Lanes:
    Vector + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Proof that this machine has the instructions.
    type Cpu: Copy;
    type Mask: Mask;
    type Ints: Ints;
    /// Whether a value is a register, not an array.
    const REGISTERS: bool;

    fn splat(cpu: Self::Cpu, value: f32) -> Self;
    /// Reads `WIDTH` values.
    fn load(cpu: Self::Cpu, from: &[f32]) -> Self;
    /// Writes `WIDTH` values.
    fn store(self, to: &mut [f32]);
    fn sqrt(self) -> Self;
    /// The greater of the absolute values.
    fn max_abs(self, other: Self) -> Self;
    /// The value, or the nearer of ± `limit` (above 0) beyond them.
    fn clamp(self, limit: Self) -> Self;
    /// `self > other ? self : other`
    fn max(self, other: Self) -> Self;
    fn lt(self, other: Self) -> Self::Mask;
    /// `self < other`, in the lanes of the mask only.
    #[inline(always)]
    fn lt_among(self, other: Self, lanes: Self::Mask) -> Self::Mask {
        lanes & self.lt(other)
    }
    fn eq(self, other: Self) -> Self::Mask;
    /// `mask ? yes : no`
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// The mask with these [`Mask::bits`].
    fn mask(cpu: Self::Cpu, bits: u32) -> Self::Mask;
    fn int_splat(cpu: Self::Cpu, value: i32) -> Self::Ints;
    /// Reads `WIDTH` values.
    fn int_load(cpu: Self::Cpu, from: &[i32]) -> Self::Ints;
    fn int_select(mask: Self::Mask, yes: Self::Ints, no: Self::Ints) -> Self::Ints;
    fn is_zero(value: Self::Ints) -> Self::Mask;

    /// Cosine and sine of headings; only the lowest six bits matter.
    fn cos_sin(heading: Self::Ints) -> (Self, Self);
    /// Turn (right − left level) and travel of a response code; only the lowest four bits matter.
    fn drive(code: Self::Ints, travel: &[f32; 16]) -> (Self::Ints, Self);
}

/// Right − left level by response code (left + 4 · right).
static TURN: [i32; 16] = {
    let mut turn = [0; 16];
    let mut code = 0;
    while code < 16 {
        turn[code] = (code as i32 >> 2) - (code as i32 & 3);
        code += 1;
    }
    turn
};
