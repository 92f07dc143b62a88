//! The schema as data: what a payload and a code are, with fields, their places, types and meanings.
//!
//! In: the declarations of this crate, through the macros that make them. Out: the words of [the catalogue](crate::catalogue).

use crate::text::Text;

/// What a field is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Type {
    /// A floating-point number of 4 bytes.
    F32,
    /// A floating-point number of 8 bytes.
    F64,
    /// An unsigned number of 4 bytes.
    U32,
    /// An unsigned number of 8 bytes.
    U64,
    /// UTF-8 text of so many bytes, filled up with zeros.
    Text(usize),
    /// A code: an unsigned number of 4 bytes with named values.
    Code(&'static CodeType),
    /// Another payload.
    Payload(&'static PayloadType),
    /// So many of one type, one after the other.
    Array(&'static Self, usize),
}

/// A payload: `#[repr(C)]`, little-endian, without gaps.
#[derive(Debug, PartialEq)]
pub struct PayloadType {
    /// Its name in this crate.
    pub name: &'static str,
    /// Its versioned name on the bus.
    pub wire: &'static str,
    /// What it is, line by line.
    pub about: &'static [&'static str],
    /// Bytes.
    pub size: usize,
    /// Alignment, bytes.
    pub align: usize,
    /// Its fields, in order.
    pub fields: &'static [Field],
}

/// A field of a payload.
#[derive(Debug, PartialEq)]
pub struct Field {
    /// Its name; a unit stands last in it.
    pub name: &'static str,
    /// Bytes before it.
    pub offset: usize,
    /// Bytes of it.
    pub size: usize,
    /// What it is made of.
    pub kind: Type,
    /// What it means, line by line.
    pub about: &'static [&'static str],
}

/// A code.
#[derive(Debug, PartialEq)]
pub struct CodeType {
    /// Its name in this crate.
    pub name: &'static str,
    /// What it is, line by line.
    pub about: &'static [&'static str],
    /// Its known values, in order.
    pub values: &'static [CodeValue],
}

/// A value of a code.
#[derive(Debug, PartialEq)]
pub struct CodeValue {
    /// The number on the wire.
    pub number: u32,
    /// Its name in programs.
    pub name: &'static str,
    /// Its name in logs and JSON.
    pub text: &'static str,
    /// What it means, line by line.
    pub about: &'static [&'static str],
}

/// What can be part of a payload.
pub trait Described {
    /// What it is made of.
    const TYPE: Type;
}

macro_rules! numbers {
    ($($number:ty: $kind:ident)*) => {$(
        impl Described for $number {
            const TYPE: Type = Type::$kind;
        }
    )*};
}
numbers! { f32: F32 f64: F64 u32: U32 u64: U64 }

impl<const N: usize> Described for Text<N> {
    const TYPE: Type = Type::Text(N);
}

impl<T: Described, const N: usize> Described for [T; N] {
    const TYPE: Type = Type::Array(&T::TYPE, N);
}
