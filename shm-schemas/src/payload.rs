//! What a payload is, and how one is declared.

use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// What every payload is: plain bytes without padding that any process may read at any time.
pub trait Payload:
    ZeroCopySend + FromBytes + IntoBytes + Immutable + KnownLayout + Copy + core::fmt::Debug + 'static
{
    /// The versioned type name that iceoryx2 compares when a peer opens a service.
    const TYPE_NAME: &'static str;
}

/// Declares a payload: `#[repr(C)]`, versioned, without padding (checked when it compiles), zero by default.
macro_rules! payload {
    ($(#[$doc:meta])* $name:ident as $wire:literal {
        $($(#[$fdoc:meta])* pub $field:ident: $type:ty,)*
    }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(
            Clone, Copy, Debug, PartialEq,
            iceoryx2_bb_derive_macros::ZeroCopySend,
            zerocopy::FromBytes, zerocopy::IntoBytes, zerocopy::Immutable, zerocopy::KnownLayout,
        )]
        #[type_name($wire)]
        pub struct $name {
            $($(#[$fdoc])* pub $field: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                <Self as zerocopy::FromZeros>::new_zeroed()
            }
        }

        impl $crate::payload::Payload for $name {
            const TYPE_NAME: &'static str = $wire;
        }

        impl $name {
            /// Every field's name, offset and size in bytes, in order: what the golden layout test pins.
            pub const FIELDS: &'static [(&'static str, usize, usize)] = &[
                $((stringify!($field), core::mem::offset_of!($name, $field), core::mem::size_of::<$type>()),)*
            ];
        }
    };
}
pub(crate) use payload;
