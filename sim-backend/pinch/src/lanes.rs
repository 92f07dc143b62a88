//! Numbers and truth values, one trial per lane.
//!
//! The compiler maps the plain arrays to the registers that [`crate::Engine`] selects. Operations
//! round like scalar ones and nothing is fused, so the width changes no bit.

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Lanes<const N: usize>(pub(crate) [f32; N]);

/// All bits of a true lane are set.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Mask<const N: usize>(pub(crate) [u32; N]);

macro_rules! lanewise {
    ($($trait:ident $method:ident $assign:tt;)*) => {$(
        impl<const N: usize> $trait for Lanes<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for (a, b) in self.0.iter_mut().zip(other.0) {
                    *a $assign b;
                }
                self
            }
        }

        impl<const N: usize> $trait<f32> for Lanes<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: f32) -> Self {
                for a in &mut self.0 {
                    *a $assign other;
                }
                self
            }
        }
    )*};
}

lanewise! {
    Add add +=;
    Sub sub -=;
    Mul mul *=;
    Div div /=;
}

impl<const N: usize> Lanes<N> {
    #[inline(always)]
    pub(crate) fn splat(value: f32) -> Self {
        Self([value; N])
    }

    #[inline(always)]
    pub(crate) fn from_fn(mut value: impl FnMut(usize) -> f32) -> Self {
        let mut lanes = Self([0.0; N]);
        for (lane, number) in lanes.0.iter_mut().enumerate() {
            *number = value(lane);
        }
        lanes
    }

    #[inline(always)]
    pub(crate) fn gt(self, other: Self) -> Mask<N> {
        let mut mask = Mask([0; N]);
        for ((m, a), b) in mask.0.iter_mut().zip(self.0).zip(other.0) {
            *m = if a > b { u32::MAX } else { 0 };
        }
        mask
    }

    #[inline(always)]
    pub(crate) fn above(self, limit: f32) -> Mask<N> {
        self.gt(Self::splat(limit))
    }

    #[inline(always)]
    pub(crate) fn below(self, limit: f32) -> Mask<N> {
        Self::splat(limit).gt(self)
    }

    /// `self > other ? self : other`
    #[inline(always)]
    pub(crate) fn greater(mut self, other: Self) -> Self {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a = if *a > b { *a } else { b };
        }
        self
    }

    /// `self < other ? self : other`
    #[inline(always)]
    pub(crate) fn lesser(mut self, other: Self) -> Self {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a = if *a < b { *a } else { b };
        }
        self
    }

    #[inline(always)]
    pub(crate) fn abs(mut self) -> Self {
        for a in &mut self.0 {
            *a = f32::from_bits(a.to_bits() & 0x7fff_ffff);
        }
        self
    }

    /// Magnitude of this number, sign of another.
    #[inline(always)]
    pub(crate) fn with_sign(mut self, of: Self) -> Self {
        for (a, b) in self.0.iter_mut().zip(of.0) {
            *a = f32::from_bits(a.to_bits() & 0x7fff_ffff | b.to_bits() & 0x8000_0000);
        }
        self
    }

    /// One step of a first-order low-pass.
    #[inline(always)]
    pub(crate) fn towards(self, value: Self, share: f32) -> Self {
        self + (value - self) * share
    }
}

impl<const N: usize> Mask<N> {
    pub(crate) const NONE: Self = Self([0; N]);

    #[inline(always)]
    pub(crate) fn select(self, yes: Lanes<N>, no: Lanes<N>) -> Lanes<N> {
        let mut chosen = no;
        for ((c, y), m) in chosen.0.iter_mut().zip(yes.0).zip(self.0) {
            *c = f32::from_bits(y.to_bits() & m | c.to_bits() & !m);
        }
        chosen
    }

    #[inline(always)]
    pub(crate) fn any(self) -> bool {
        self.0.iter().fold(0, |any, m| any | m) != 0
    }
}

macro_rules! maskwise {
    ($($trait:ident $method:ident $assign:tt;)*) => {$(
        impl<const N: usize> $trait for Mask<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for (a, b) in self.0.iter_mut().zip(other.0) {
                    *a $assign b;
                }
                self
            }
        }
    )*};
}

maskwise! {
    BitAnd bitand &=;
    BitOr bitor |=;
}

impl<const N: usize> Not for Mask<N> {
    type Output = Self;
    #[inline(always)]
    fn not(mut self) -> Self {
        for a in &mut self.0 {
            *a = !*a;
        }
        self
    }
}
