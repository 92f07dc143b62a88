//! Four lanes in one AVX2 register.
#![expect(
    unsafe_code,
    reason = "AVX2 intrinsics; their values exist only after AVX2 was detected"
)]

use core::arch::x86_64::*;
use core::ops::{Add, BitAnd, Div, Mul, Sub};

use super::{LaneSet, Lanes, Row};

/// Proof that this machine has AVX2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cpu(());

impl Cpu {
    #[inline(always)]
    pub(crate) fn detect() -> Option<Self> {
        is_x86_feature_detected!("avx2").then_some(Self(()))
    }
}

#[derive(Clone, Copy)]
pub(crate) struct Numbers(__m256d);

/// Four truth values: all bits of a true lane are set.
#[derive(Clone, Copy)]
pub(crate) struct Truths(__m256d);

/// Calls an AVX2 intrinsic on values whose existence proves AVX2.
macro_rules! avx2 {
    ($call:expr) => {
        // SAFETY: the operands are lane values or came with a `Cpu`; both exist only after AVX2 was
        // detected. Loads and stores use references to whole rows.
        unsafe { $call }
    };
}

macro_rules! operators {
    ($($trait:ident $method:ident $type:ident $intrinsic:ident;)*) => {$(
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(avx2!($intrinsic(self.0, other.0)))
            }
        }
    )*};
}

operators! {
    Add add Numbers _mm256_add_pd;
    Sub sub Numbers _mm256_sub_pd;
    Mul mul Numbers _mm256_mul_pd;
    Div div Numbers _mm256_div_pd;
    BitAnd bitand Truths _mm256_and_pd;
}

impl Lanes for Numbers {
    type Cpu = Cpu;
    type Mask = Truths;

    #[inline(always)]
    fn splat(_: Cpu, value: f64) -> Self {
        Self(avx2!(_mm256_set1_pd(value)))
    }

    #[inline(always)]
    fn load(_: Cpu, row: &Row) -> Self {
        Self(avx2!(_mm256_loadu_pd(row.as_ptr())))
    }

    #[inline(always)]
    fn store(self) -> Row {
        let mut row = Row::default();
        avx2!(_mm256_storeu_pd(row.as_mut_ptr(), self.0));
        row
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(avx2!(_mm256_sqrt_pd(self.0)))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(avx2!(_mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0)))
    }

    #[inline(always)]
    fn above(self, other: Self) -> Truths {
        Truths(avx2!(_mm256_cmp_pd::<_CMP_GT_OQ>(self.0, other.0)))
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> Truths {
        Truths(avx2!(_mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0)))
    }

    #[inline(always)]
    fn select(mask: Truths, yes: Self, no: Self) -> Self {
        Self(avx2!(_mm256_blendv_pd(no.0, yes.0, mask.0)))
    }

    #[inline(always)]
    fn set(mask: Truths) -> LaneSet {
        LaneSet::from_bits(avx2!(_mm256_movemask_pd(mask.0)) as u8)
    }
}
