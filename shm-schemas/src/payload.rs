//! What a payload is, and how one is declared.

use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use crate::schema::PayloadType;

/// What every payload is: plain bytes without padding that any process may read at any time.
pub trait Payload:
    ZeroCopySend + FromBytes + IntoBytes + Immutable + KnownLayout + Copy + core::fmt::Debug + 'static
{
    /// The versioned type name that iceoryx2 compares when a peer opens a service.
    const TYPE_NAME: &'static str;
    /// Its fields, for those who are not written in Rust.
    const SCHEMA: &'static PayloadType;
}

/// Declares a payload: `#[repr(C)]`, versioned, without padding (checked when it compiles), zero by default.
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

        impl $crate::schema::Described for $name {
            const TYPE: $crate::schema::Type = $crate::schema::Type::Payload(&Self::PAYLOAD);
        }

        impl $name {
            /// Every field's name, offset and size in bytes, in order: what the golden layout test pins.
            pub const FIELDS: &'static [(&'static str, usize, usize)] = &[
                $((stringify!($field), core::mem::offset_of!($name, $field), core::mem::size_of::<$type>()),)*
            ];

            /// The payload as other languages are told of it.
            pub const PAYLOAD: $crate::schema::PayloadType = $crate::schema::PayloadType {
                name: stringify!($name),
                wire: $wire,
                about: &[$($doc),*],
                size: core::mem::size_of::<$name>(),
                align: core::mem::align_of::<$name>(),
                fields: &[$($crate::schema::Field {
                    name: stringify!($field),
                    offset: core::mem::offset_of!($name, $field),
                    size: core::mem::size_of::<$type>(),
                    kind: <$type as $crate::schema::Described>::TYPE,
                    about: &[$($fdoc),*],
                }),*],
            };
        }
    };
}
pub(crate) use payload;
