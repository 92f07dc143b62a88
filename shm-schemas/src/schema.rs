//! Schema as data: payloads, codes and fields with offsets, types and descriptions. The declaration
//! macros of this crate create it for the [catalogue](crate::catalogue).

use crate::text::Text;

/// Type of a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Type {
    /// 4-byte floating-point number.
    F32,
    /// 8-byte floating-point number.
    F64,
    /// 4-byte unsigned number.
    U32,
    /// 8-byte unsigned number.
    U64,
    /// Zero-padded UTF-8 text of this many bytes.
    Text(usize),
    /// Code: 4-byte unsigned number with named values.
    Code(&'static CodeType),
    /// Another payload.
    Payload(&'static PayloadType),
    /// Array of one type with this many elements.
    Array(&'static Self, usize),
}

/// Payload: `#[repr(C)]`, little-endian, without gaps.
#[derive(Debug, PartialEq)]
pub struct PayloadType {
    /// Name in other languages: the versioned name without `atas.` and version.
    pub name: &'static str,
    /// Versioned name on the bus.
    pub wire: &'static str,
    /// Description, line by line.
    pub doc: &'static [&'static str],
    /// Size, bytes.
    pub size: usize,
    /// Alignment, bytes.
    pub align: usize,
    /// Fields, in order.
    pub fields: &'static [Field],
}

/// A field of a payload.
#[derive(Debug, PartialEq)]
pub struct Field {
    /// Name, with the unit as suffix.
    pub name: &'static str,
    /// Offset, bytes.
    pub offset: usize,
    /// Size, bytes.
    pub size: usize,
    /// Type.
    pub kind: Type,
    /// Description, line by line.
    pub doc: &'static [&'static str],
}

/// Code.
#[derive(Debug, PartialEq)]
pub struct CodeType {
    /// Name in this crate.
    pub name: &'static str,
    /// Description, line by line.
    pub doc: &'static [&'static str],
    /// Known values, in order.
    pub values: &'static [CodeValue],
}

/// Value of a code.
#[derive(Debug, PartialEq)]
pub struct CodeValue {
    /// Number on the wire.
    pub number: u32,
    /// Name in programs.
    pub name: &'static str,
    /// Name in logs and JSON.
    pub text: &'static str,
    /// Description, line by line.
    pub doc: &'static [&'static str],
}

/// Returns the part of a versioned name between `atas.` and the version.
pub(crate) const fn base_name(wire: &str) -> &str {
    let (_, name) = wire.split_at("atas.".len());
    let mut end = name.len();
    while name.as_bytes()[end - 1] != b'.' {
        end -= 1;
    }
    name.split_at(end - 1).0
}

/// Types that can be part of a payload.
pub trait HasSchema {
    /// Schema type.
    const TYPE: Type;
}

macro_rules! numbers {
    ($($number:ty: $kind:ident)*) => {$(
        impl HasSchema for $number {
            const TYPE: Type = Type::$kind;
        }
    )*};
}
numbers! { f32: F32 f64: F64 u32: U32 u64: U64 }

impl<const N: usize> HasSchema for Text<N> {
    const TYPE: Type = Type::Text(N);
}

impl<T: HasSchema, const N: usize> HasSchema for [T; N] {
    const TYPE: Type = Type::Array(&T::TYPE, N);
}
