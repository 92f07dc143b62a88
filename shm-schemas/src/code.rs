//! Codes: `u32` numbers with named values.
//!
//! Foreign memory must not be read as a Rust `enum`, because an unknown value is undefined
//! behaviour. A code accepts any `u32`; an unknown value remains readable and prints as unknown.

/// Declares a code: a `#[repr(C)]` newtype of `u32` with named values.
macro_rules! code {
    ($(#[doc = $doc:literal])* $name:ident as $wire:literal {
        $($(#[doc = $vdoc:literal])* $value:ident = $number:literal, $text:literal;)*
    }) => {
        $(#[doc = $doc])*
        #[repr(C)]
        #[derive(
            Clone, Copy, PartialEq, Eq, Hash, Default,
            iceoryx2_bb_derive_macros::ZeroCopySend,
            zerocopy::FromBytes, zerocopy::IntoBytes, zerocopy::Immutable, zerocopy::KnownLayout,
        )]
        #[type_name($wire)]
        pub struct $name(
            /// Number on the wire.
            pub u32,
        );

        impl $name {
            $($(#[doc = $vdoc])* pub const $value: Self = Self($number);)*

            /// All known values.
            pub const ALL: &'static [Self] = &[$(Self::$value),*];

            /// Schema of the code for other languages.
            pub const CODE: $crate::schema::CodeType = $crate::schema::CodeType {
                name: stringify!($name),
                doc: &[$($doc),*],
                values: &[$($crate::schema::CodeValue {
                    number: $number,
                    name: stringify!($value),
                    text: $text,
                    doc: &[$($vdoc),*],
                }),*],
            };

            /// Returns the name in logs and JSON, or `"unknown"`.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self.0 {
                    $($number => $text,)*
                    _ => "unknown",
                }
            }

            /// Returns true if the value is known. Check before acting on a value from the bus.
            #[must_use]
            #[allow(clippy::manual_range_patterns, reason = "the macro cannot know whether the values are consecutive")]
            pub const fn is_known(self) -> bool {
                matches!(self.0, $($number)|*)
            }

            /// Returns the value with this name.
            #[must_use]
            pub fn from_name(name: &str) -> Option<Self> {
                match name {
                    $($text => Some(Self::$value),)*
                    _ => None,
                }
            }
        }

        #[cfg(feature = "serde")]
        $crate::bytes::as_bytes!($name);

        impl $crate::schema::HasSchema for $name {
            const TYPE: $crate::schema::Type = $crate::schema::Type::Code(&Self::CODE);
        }

        impl core::fmt::Display for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                if self.is_known() { f.pad(self.name()) } else { write!(f, "unknown({})", self.0) }
            }
        }

        impl core::fmt::Debug for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                core::fmt::Display::fmt(self, f)
            }
        }
    };
}
pub(crate) use code;
