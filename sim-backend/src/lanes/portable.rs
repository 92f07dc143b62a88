//! Four lanes in plain arrays, vectorised by the compiler.

use core::ops::{Add, BitAnd, Div, Mul, Sub};

use super::{LANES, LaneSet, Lanes, Row};

#[derive(Clone, Copy)]
pub(crate) struct Numbers(Row);

#[derive(Clone, Copy)]
pub(crate) struct Truths([bool; LANES]);

macro_rules! operators {
    ($($trait:ident $method:ident $symbol:tt;)*) => {$(
        impl $trait for Numbers {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(core::array::from_fn(|lane| self.0[lane] $symbol other.0[lane]))
            }
        }
    )*};
}

operators! {
    Add add +;
    Sub sub -;
    Mul mul *;
    Div div /;
}

impl BitAnd for Truths {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(core::array::from_fn(|lane| self.0[lane] & other.0[lane]))
    }
}

impl Lanes for Numbers {
    /// No proof needed: plain Rust runs on every machine.
    type Cpu = ();
    type Mask = Truths;

    #[inline(always)]
    fn splat((): (), value: f64) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    fn load((): (), row: &Row) -> Self {
        Self(*row)
    }

    #[inline(always)]
    fn store(self) -> Row {
        self.0
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }

    #[inline(always)]
    fn above(self, other: Self) -> Truths {
        Truths(core::array::from_fn(|lane| self.0[lane] > other.0[lane]))
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> Truths {
        Truths(core::array::from_fn(|lane| self.0[lane] <= other.0[lane]))
    }

    #[inline(always)]
    fn select(mask: Truths, yes: Self, no: Self) -> Self {
        Self(core::array::from_fn(|lane| {
            if mask.0[lane] {
                yes.0[lane]
            } else {
                no.0[lane]
            }
        }))
    }

    #[inline(always)]
    fn set(mask: Truths) -> LaneSet {
        let bits = (0..LANES).map(|lane| u8::from(mask.0[lane]) << lane);
        LaneSet::from_bits(bits.fold(0, |set, bit| set | bit))
    }
}
