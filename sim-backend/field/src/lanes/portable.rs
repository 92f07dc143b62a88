//! Eight lanes in plain arrays; the compiler vectorises where it can.

use std::array::from_fn;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Sub};

use super::{Ints, Lanes, Mask, TURN, Vector};
use crate::arithmetic::clamp;
use crate::heading::COSINE;

const WIDTH: usize = 8;

#[derive(Clone, Copy)]
pub(crate) struct Floats([f32; WIDTH]);
#[derive(Clone, Copy)]
pub(crate) struct Integers([i32; WIDTH]);
/// −1 is true, 0 is false.
#[derive(Clone, Copy)]
pub(crate) struct Booleans([i32; WIDTH]);

impl Vector for Floats {
    const WIDTH: usize = WIDTH;
}
impl Vector for Integers {
    const WIDTH: usize = WIDTH;
}
impl Vector for Booleans {
    const WIDTH: usize = WIDTH;
}

macro_rules! operator {
    ($trait:ident, $method:ident, $type:ident, |$a:ident, $b:ident| $value:expr) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(from_fn(|k| {
                    let ($a, $b) = (self.0[k], other.0[k]);
                    $value
                }))
            }
        }
    };
}

operator!(Add, add, Floats, |a, b| a + b);
operator!(Sub, sub, Floats, |a, b| a - b);
operator!(Mul, mul, Floats, |a, b| a * b);
operator!(Div, div, Floats, |a, b| a / b);
operator!(Add, add, Integers, |a, b| a.wrapping_add(b));
operator!(BitAnd, bitand, Integers, |a, b| a & b);
operator!(BitOr, bitor, Integers, |a, b| a | b);
operator!(BitXor, bitxor, Integers, |a, b| a ^ b);
operator!(BitAnd, bitand, Booleans, |a, b| a & b);
operator!(BitOr, bitor, Booleans, |a, b| a | b);

impl Mask for Booleans {
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0
            .iter()
            .rev()
            .fold(0, |bits, &lane| bits << 1 | u32::from(lane != 0))
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0.iter().fold(0, |any, lane| any | lane) != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0.iter().fold(-1, |all, lane| all & lane) != 0
    }
}

impl Ints for Integers {
    #[inline(always)]
    fn bit(self) -> Self {
        Self(self.0.map(|count| 1 << (count & 31)))
    }
    #[inline(always)]
    fn shl(self, count: Self) -> Self {
        Self(from_fn(|k| self.0[k] << (count.0[k] & 31)))
    }
    #[inline(always)]
    fn shr(self, count: Self) -> Self {
        Self(from_fn(|k| {
            (self.0[k] as u32 >> (count.0[k] as u32 % 32)) as i32
        }))
    }
    #[inline(always)]
    fn store(self, to: &mut [i32]) {
        to[..WIDTH].copy_from_slice(&self.0);
    }
}

impl Lanes for Floats {
    type Cpu = ();
    type Mask = Booleans;
    type Ints = Integers;
    const REGISTERS: bool = false;

    #[inline(always)]
    fn splat((): (), value: f32) -> Self {
        Self([value; WIDTH])
    }
    #[inline(always)]
    fn load((): (), from: &[f32]) -> Self {
        Self(*from.first_chunk().expect("eight lanes"))
    }
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        to[..WIDTH].copy_from_slice(&self.0);
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }
    #[inline(always)]
    fn max_abs(self, other: Self) -> Self {
        Self(self.0.map(f32::abs)).max(Self(other.0.map(f32::abs)))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(from_fn(|k| {
            if self.0[k] > other.0[k] {
                self.0[k]
            } else {
                other.0[k]
            }
        }))
    }
    #[inline(always)]
    fn clamp(self, limit: Self) -> Self {
        Self(from_fn(|k| clamp(self.0[k], limit.0[k])))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Booleans {
        Booleans(from_fn(|k| -i32::from(self.0[k] < other.0[k])))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Booleans {
        Booleans(from_fn(|k| -i32::from(self.0[k] == other.0[k])))
    }
    #[inline(always)]
    fn select(mask: Booleans, yes: Self, no: Self) -> Self {
        Self(from_fn(|k| if mask.0[k] != 0 { yes.0[k] } else { no.0[k] }))
    }
    #[inline(always)]
    fn mask((): (), bits: u32) -> Booleans {
        Booleans(from_fn(|k| -((bits >> k & 1) as i32)))
    }
    #[inline(always)]
    fn int_splat((): (), value: i32) -> Integers {
        Integers([value; WIDTH])
    }
    #[inline(always)]
    fn int_load((): (), from: &[i32]) -> Integers {
        Integers(*from.first_chunk().expect("eight lanes"))
    }
    #[inline(always)]
    fn int_select(mask: Booleans, yes: Integers, no: Integers) -> Integers {
        Integers(from_fn(|k| mask.0[k] & yes.0[k] | !mask.0[k] & no.0[k]))
    }
    #[inline(always)]
    fn is_zero(value: Integers) -> Booleans {
        Booleans(value.0.map(|lane| -i32::from(lane == 0)))
    }
    #[inline(always)]
    fn cos_sin(heading: Integers) -> (Self, Self) {
        let cosine = |back: i32| {
            Self(
                heading
                    .0
                    .map(|h| COSINE[(h.wrapping_add(back) & 63) as usize]),
            )
        };
        (cosine(0), cosine(48))
    }
    #[inline(always)]
    fn drive(code: Integers, travel: &[f32; 16]) -> (Integers, Self) {
        let index = code.0.map(|c| (c & 15) as usize);
        (
            Integers(index.map(|c| TURN[c])),
            Self(index.map(|c| travel[c])),
        )
    }
}
