//! Serde support for payloads in a saved state. A payload is stored as its bytes on the bus and is
//! read back only if the size is unchanged.

use core::fmt;
use core::marker::PhantomData;

use serde::de::{Error, SeqAccess, Visitor};
use zerocopy::{FromBytes, IntoBytes};

/// Visitor that reads a `T` from exactly `size_of::<T>()` bytes.
pub(crate) struct BytesVisitor<T>(pub(crate) PhantomData<T>);

impl<'de, T: FromBytes + IntoBytes> Visitor<'de> for BytesVisitor<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes", size_of::<T>())
    }

    fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<T, E> {
        T::read_from_bytes(bytes).map_err(|_| E::invalid_length(bytes.len(), &self))
    }

    /// Handles formats without a byte type, which store bytes as a sequence.
    fn visit_seq<A: SeqAccess<'de>>(self, mut bytes: A) -> Result<T, A::Error> {
        let mut value = T::new_zeroed();
        for (at, byte) in value.as_mut_bytes().iter_mut().enumerate() {
            let next = bytes.next_element()?;
            *byte = next.ok_or_else(|| A::Error::invalid_length(at, &self))?;
        }
        Ok(value)
    }
}

/// Implements `Serialize` and `Deserialize` for a plain-bytes type.
macro_rules! as_bytes {
    ($name:ident $(<const $n:ident: usize>)?) => {
        impl $(<const $n: usize>)? serde::Serialize for $name $(<$n>)? {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_bytes(zerocopy::IntoBytes::as_bytes(self))
            }
        }

        impl<'de $(, const $n: usize)?> serde::Deserialize<'de> for $name $(<$n>)? {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                deserializer.deserialize_bytes($crate::bytes::BytesVisitor(core::marker::PhantomData))
            }
        }
    };
}
pub(crate) use as_bytes;
