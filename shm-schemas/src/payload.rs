//! The payload trait and the macro that declares payloads.

use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use crate::schema::PayloadType;

/// Plain data without padding that any process can read at any time.
pub trait Payload:
    ZeroCopySend + FromBytes + IntoBytes + Immutable + KnownLayout + Copy + core::fmt::Debug + 'static
{
    /// Versioned type name, compared by iceoryx2 when a peer opens a service.
    const TYPE_NAME: &'static str;
    /// Field descriptions for programs in other languages.
    const SCHEMA: &'static PayloadType;
}

/// Declares a payload: `#[repr(C)]`, versioned, without padding (checked at compile time), zero by
/// default.
macro_rules! payload {
    ($(#[doc = $doc:literal])* $name:ident as $wire:literal {
        $($(#[doc = $fdoc:literal])* pub $field:ident: $type:ty,)*
    }) => {
        $(#[doc = $doc])*
        #[repr(C)]
        #[derive(
            Clone, Copy, Debug, PartialEq,
            iceoryx2_bb_derive_macros::ZeroCopySend,
            zerocopy::FromBytes, zerocopy::IntoBytes, zerocopy::Immutable, zerocopy::KnownLayout,
        )]
        #[type_name($wire)]
        pub struct $name {
            $($(#[doc = $fdoc])* pub $field: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                <Self as zerocopy::FromZeros>::new_zeroed()
            }
        }

        impl $crate::payload::Payload for $name {
            const TYPE_NAME: &'static str = $wire;
            const SCHEMA: &'static $crate::schema::PayloadType = &$name::PAYLOAD;
        }

        #[cfg(feature = "serde")]
        $crate::bytes::as_bytes!($name);

        impl $crate::schema::HasSchema for $name {
            const TYPE: $crate::schema::Type = $crate::schema::Type::Payload(&Self::PAYLOAD);
        }

        impl $name {
            /// Name, offset and size in bytes of every field, in order; pinned by the golden layout
            /// test.
            pub const FIELDS: &'static [(&'static str, usize, usize)] = &[
                $((stringify!($field), core::mem::offset_of!($name, $field), core::mem::size_of::<$type>()),)*
            ];

            /// Schema of the payload for other languages.
            pub const PAYLOAD: $crate::schema::PayloadType = $crate::schema::PayloadType {
                name: $crate::schema::base_name($wire),
                wire: $wire,
                doc: &[$($doc),*],
                size: core::mem::size_of::<$name>(),
                align: core::mem::align_of::<$name>(),
                fields: &[$($crate::schema::Field {
                    name: stringify!($field),
                    offset: core::mem::offset_of!($name, $field),
                    size: core::mem::size_of::<$type>(),
                    kind: <$type as $crate::schema::HasSchema>::TYPE,
                    doc: &[$($fdoc),*],
                }),*],
            };
        }
    };
}
pub(crate) use payload;
