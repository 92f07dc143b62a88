//! Eight lanes in AVX2 registers.

use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Sub};

use super::{Ints, Lanes, Mask, Vector};
use crate::heading::COSINE;

/// Proof of AVX2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cpu(());

impl Cpu {
    pub(crate) fn detect() -> Option<Self> {
        is_x86_feature_detected!("avx2").then_some(Self(()))
    }
}

#[derive(Clone, Copy)]
pub(crate) struct F32x8(__m256);
#[derive(Clone, Copy)]
pub(crate) struct I32x8(__m256i);
#[derive(Clone, Copy)]
pub(crate) struct Mask8(__m256);

impl Vector for F32x8 {
    const WIDTH: usize = 8;
}
impl Vector for I32x8 {
    const WIDTH: usize = 8;
}
impl Vector for Mask8 {
    const WIDTH: usize = 8;
}

/// Calls an AVX2 intrinsic; the operands prove AVX2.
macro_rules! avx2 {
    ($call:expr) => {
        // SAFETY: the operands are lane values or a `Cpu`, which exist only after AVX2 was
        // detected. Loads, gathers and stores use arrays of checked length, with indices masked to
        // it.
        unsafe { $call }
    };
}

macro_rules! operator {
    ($trait:ident, $method:ident, $type:ident, $intrinsic:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(avx2!($intrinsic(self.0, other.0)))
            }
        }
    };
}

operator!(Add, add, F32x8, _mm256_add_ps);
operator!(Sub, sub, F32x8, _mm256_sub_ps);
operator!(Mul, mul, F32x8, _mm256_mul_ps);
operator!(Div, div, F32x8, _mm256_div_ps);
operator!(Add, add, I32x8, _mm256_add_epi32);
operator!(BitAnd, bitand, I32x8, _mm256_and_si256);
operator!(BitOr, bitor, I32x8, _mm256_or_si256);
operator!(BitXor, bitxor, I32x8, _mm256_xor_si256);
operator!(BitAnd, bitand, Mask8, _mm256_and_ps);
operator!(BitOr, bitor, Mask8, _mm256_or_ps);

impl Mask for Mask8 {
    #[inline(always)]
    fn bits(self) -> u32 {
        avx2!(_mm256_movemask_ps(self.0)) as u32
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.bits() == 0xff
    }
}

impl Ints for I32x8 {
    #[inline(always)]
    fn bit(self) -> Self {
        Self(avx2!(_mm256_sllv_epi32(_mm256_set1_epi32(1), self.0)))
    }
    #[inline(always)]
    fn shl(self, count: Self) -> Self {
        Self(avx2!(_mm256_sllv_epi32(self.0, count.0)))
    }
    #[inline(always)]
    fn shr(self, count: Self) -> Self {
        Self(avx2!(_mm256_srlv_epi32(self.0, count.0)))
    }
    #[inline(always)]
    fn store(self, to: &mut [i32]) {
        let to: &mut [i32; 8] = to.first_chunk_mut().expect("eight lanes");
        avx2!(_mm256_storeu_si256(to.as_mut_ptr().cast(), self.0));
    }
}

impl Lanes for F32x8 {
    type Cpu = Cpu;
    type Mask = Mask8;
    type Ints = I32x8;
    const REGISTERS: bool = true;

    #[inline(always)]
    fn splat(_: Cpu, value: f32) -> Self {
        Self(avx2!(_mm256_set1_ps(value)))
    }
    #[inline(always)]
    fn load(_: Cpu, from: &[f32]) -> Self {
        let from: &[f32; 8] = from.first_chunk().expect("eight lanes");
        Self(avx2!(_mm256_loadu_ps(from.as_ptr())))
    }
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        let to: &mut [f32; 8] = to.first_chunk_mut().expect("eight lanes");
        avx2!(_mm256_storeu_ps(to.as_mut_ptr(), self.0));
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(avx2!(_mm256_sqrt_ps(self.0)))
    }
    #[inline(always)]
    fn max_abs(self, other: Self) -> Self {
        let sign = avx2!(_mm256_set1_ps(-0.0));
        let abs = |v| avx2!(_mm256_andnot_ps(sign, v));
        Self(avx2!(_mm256_max_ps(abs(self.0), abs(other.0))))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(avx2!(_mm256_max_ps(self.0, other.0)))
    }
    #[inline(always)]
    fn clamp(self, limit: Self) -> Self {
        let least = avx2!(_mm256_xor_ps(_mm256_set1_ps(-0.0), limit.0));
        Self(avx2!(_mm256_min_ps(_mm256_max_ps(self.0, least), limit.0)))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask8 {
        Mask8(avx2!(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Mask8 {
        Mask8(avx2!(_mm256_cmp_ps::<_CMP_EQ_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn select(mask: Mask8, yes: Self, no: Self) -> Self {
        Self(avx2!(_mm256_blendv_ps(no.0, yes.0, mask.0)))
    }
    #[inline(always)]
    fn mask(_: Cpu, bits: u32) -> Mask8 {
        let lane = avx2!(_mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128));
        let set = avx2!(_mm256_and_si256(_mm256_set1_epi32(bits as i32), lane));
        Mask8(avx2!(_mm256_castsi256_ps(_mm256_cmpeq_epi32(set, lane))))
    }
    #[inline(always)]
    fn int_splat(_: Cpu, value: i32) -> I32x8 {
        I32x8(avx2!(_mm256_set1_epi32(value)))
    }
    #[inline(always)]
    fn int_load(_: Cpu, from: &[i32]) -> I32x8 {
        let from: &[i32; 8] = from.first_chunk().expect("eight lanes");
        I32x8(avx2!(_mm256_loadu_si256(from.as_ptr().cast())))
    }
    #[inline(always)]
    fn int_select(mask: Mask8, yes: I32x8, no: I32x8) -> I32x8 {
        I32x8(avx2!(_mm256_blendv_epi8(
            no.0,
            yes.0,
            _mm256_castps_si256(mask.0)
        )))
    }
    #[inline(always)]
    fn is_zero(value: I32x8) -> Mask8 {
        Mask8(avx2!(_mm256_castsi256_ps(_mm256_cmpeq_epi32(
            value.0,
            _mm256_setzero_si256()
        ))))
    }
    #[inline(always)]
    fn cos_sin(heading: I32x8) -> (Self, Self) {
        let quarter_back = avx2!(_mm256_add_epi32(heading.0, _mm256_set1_epi32(48)));
        (cosine(heading.0), cosine(quarter_back))
    }
    #[inline(always)]
    fn drive(code: I32x8, travel: &[f32; 16]) -> (I32x8, Self) {
        let level = avx2!(_mm256_set1_epi32(3));
        let left = avx2!(_mm256_and_si256(code.0, level));
        let right = avx2!(_mm256_and_si256(_mm256_srli_epi32::<2>(code.0), level));
        // Levels are at most 2, so their sum has five values: `travel[sum]` up to 2, then
        // `travel[2 + 4·(sum − 2)]`.
        let by_sum: [f32; 8] = [
            travel[0], travel[1], travel[2], travel[6], travel[10], 0.0, 0.0, 0.0,
        ];
        let sum = avx2!(_mm256_add_epi32(left, right));
        let travel = avx2!(_mm256_permutevar8x32_ps(
            _mm256_loadu_ps(by_sum.as_ptr()),
            sum
        ));
        (I32x8(avx2!(_mm256_sub_epi32(right, left))), Self(travel))
    }
}

#[inline(always)]
fn cosine(heading: __m256i) -> F32x8 {
    let index = avx2!(_mm256_and_si256(heading, _mm256_set1_epi32(63)));
    F32x8(avx2!(_mm256_i32gather_ps::<4>(COSINE.as_ptr(), index)))
}
