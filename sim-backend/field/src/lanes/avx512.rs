//! Sixteen lanes in AVX-512 registers.

use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Sub};

use super::{Ints, Lanes, Mask, TURN, Vector};
use crate::heading::COSINE;

/// Proof of AVX-512 F and DQ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cpu(());

impl Cpu {
    pub(crate) fn detect() -> Option<Self> {
        (is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq"))
            .then_some(Self(()))
    }
}

#[derive(Clone, Copy)]
pub(crate) struct F32x16(__m512);
#[derive(Clone, Copy)]
pub(crate) struct I32x16(__m512i);
#[derive(Clone, Copy)]
pub(crate) struct Mask16(__mmask16);

impl Vector for F32x16 {
    const WIDTH: usize = 16;
}
impl Vector for I32x16 {
    const WIDTH: usize = 16;
}
impl Vector for Mask16 {
    const WIDTH: usize = 16;
}

/// Calls an AVX-512 intrinsic; the operands prove F and DQ.
macro_rules! avx512 {
    ($call:expr) => {
        // SAFETY: the operands are lane values or a `Cpu`, which exist only after AVX-512 F and DQ
        // were detected. Loads and stores use slices whose length of sixteen was checked.
        unsafe { $call }
    };
}

macro_rules! operator {
    ($trait:ident, $method:ident, $type:ident, $intrinsic:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(avx512!($intrinsic(self.0, other.0)))
            }
        }
    };
}

operator!(Add, add, F32x16, _mm512_add_ps);
operator!(Sub, sub, F32x16, _mm512_sub_ps);
operator!(Mul, mul, F32x16, _mm512_mul_ps);
operator!(Div, div, F32x16, _mm512_div_ps);
operator!(Add, add, I32x16, _mm512_add_epi32);
operator!(BitAnd, bitand, I32x16, _mm512_and_si512);
operator!(BitOr, bitor, I32x16, _mm512_or_si512);
operator!(BitXor, bitxor, I32x16, _mm512_xor_si512);

impl BitAnd for Mask16 {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for Mask16 {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Mask for Mask16 {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0 != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0 == u16::MAX
    }
}

impl Ints for I32x16 {
    #[inline(always)]
    fn bit(self) -> Self {
        Self(avx512!(_mm512_rolv_epi32(_mm512_set1_epi32(1), self.0)))
    }
    #[inline(always)]
    fn shl(self, count: Self) -> Self {
        Self(avx512!(_mm512_sllv_epi32(self.0, count.0)))
    }
    #[inline(always)]
    fn shr(self, count: Self) -> Self {
        Self(avx512!(_mm512_srlv_epi32(self.0, count.0)))
    }
    #[inline(always)]
    fn store(self, to: &mut [i32]) {
        let to: &mut [i32; 16] = to.first_chunk_mut().expect("sixteen lanes");
        avx512!(_mm512_storeu_epi32(to.as_mut_ptr(), self.0));
    }
}

impl Lanes for F32x16 {
    type Cpu = Cpu;
    type Mask = Mask16;
    type Ints = I32x16;
    const REGISTERS: bool = true;

    #[inline(always)]
    fn splat(_: Cpu, value: f32) -> Self {
        Self(avx512!(_mm512_set1_ps(value)))
    }
    #[inline(always)]
    fn load(_: Cpu, from: &[f32]) -> Self {
        let from: &[f32; 16] = from.first_chunk().expect("sixteen lanes");
        Self(avx512!(_mm512_loadu_ps(from.as_ptr())))
    }
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        let to: &mut [f32; 16] = to.first_chunk_mut().expect("sixteen lanes");
        avx512!(_mm512_storeu_ps(to.as_mut_ptr(), self.0));
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(avx512!(_mm512_sqrt_ps(self.0)))
    }
    /// Immediate: larger magnitude (11), sign cleared (10).
    #[inline(always)]
    fn max_abs(self, other: Self) -> Self {
        Self(avx512!(_mm512_range_ps::<0b1011>(self.0, other.0)))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(avx512!(_mm512_max_ps(self.0, other.0)))
    }
    /// Immediate: smaller magnitude (10), sign of the first operand (00).
    #[inline(always)]
    fn clamp(self, limit: Self) -> Self {
        Self(avx512!(_mm512_range_ps::<0b0010>(self.0, limit.0)))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask16 {
        Mask16(avx512!(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn lt_among(self, other: Self, lanes: Mask16) -> Mask16 {
        Mask16(avx512!(_mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(
            lanes.0, self.0, other.0
        )))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Mask16 {
        Mask16(avx512!(_mm512_cmp_ps_mask::<_CMP_EQ_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn select(mask: Mask16, yes: Self, no: Self) -> Self {
        Self(avx512!(_mm512_mask_blend_ps(mask.0, no.0, yes.0)))
    }
    #[inline(always)]
    fn mask(_: Cpu, bits: u32) -> Mask16 {
        Mask16(bits as u16)
    }
    #[inline(always)]
    fn int_splat(_: Cpu, value: i32) -> I32x16 {
        I32x16(avx512!(_mm512_set1_epi32(value)))
    }
    #[inline(always)]
    fn int_load(_: Cpu, from: &[i32]) -> I32x16 {
        let from: &[i32; 16] = from.first_chunk().expect("sixteen lanes");
        I32x16(avx512!(_mm512_loadu_epi32(from.as_ptr())))
    }
    #[inline(always)]
    fn int_select(mask: Mask16, yes: I32x16, no: I32x16) -> I32x16 {
        I32x16(avx512!(_mm512_mask_blend_epi32(mask.0, no.0, yes.0)))
    }
    #[inline(always)]
    fn is_zero(value: I32x16) -> Mask16 {
        Mask16(avx512!(_mm512_testn_epi32_mask(value.0, value.0)))
    }
    #[inline(always)]
    fn cos_sin(heading: I32x16) -> (Self, Self) {
        // The sine is the cosine a quarter turn (16 steps) earlier; both change sign after half a
        // turn.
        let (first, second, last) = (&COSINE[..16], &COSINE[16..32], &COSINE[48..]);
        let half_turn = half_turn(heading);
        (
            flip(look_up(heading, first, second), half_turn),
            flip(look_up(heading, last, first), half_turn),
        )
    }
    #[inline(always)]
    fn drive(code: I32x16, travel: &[f32; 16]) -> (I32x16, Self) {
        let turn = avx512!(_mm512_permutexvar_epi32(
            code.0,
            _mm512_loadu_epi32(TURN.as_ptr())
        ));
        let travel = avx512!(_mm512_permutexvar_ps(
            code.0,
            _mm512_loadu_ps(travel.as_ptr())
        ));
        (I32x16(turn), Self(travel))
    }
}

/// Looks up the lowest five bits of each heading; `heading` proves the instructions.
#[inline(always)]
fn look_up(heading: I32x16, first: &[f32], second: &[f32]) -> F32x16 {
    let (first, second) = (F32x16::load(Cpu(()), first), F32x16::load(Cpu(()), second));
    F32x16(avx512!(_mm512_permutex2var_ps(
        first.0, heading.0, second.0
    )))
}

/// Sign bit of headings in the second half turn.
#[inline(always)]
fn half_turn(heading: I32x16) -> __m512i {
    avx512!(_mm512_and_si512(
        _mm512_slli_epi32::<26>(heading.0),
        _mm512_set1_epi32(i32::MIN)
    ))
}

/// Changes the sign where the sign bit is set.
#[inline(always)]
fn flip(value: F32x16, sign: __m512i) -> F32x16 {
    F32x16(avx512!(_mm512_xor_ps(value.0, _mm512_castsi512_ps(sign))))
}
