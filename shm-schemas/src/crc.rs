//! CRC-32 checksum of a payload, against bit flips and torn writes.

/// Adds `seal` and `is_intact` to a payload whose last field is `crc32`.
macro_rules! sealed {
    ($name:ident) => {
        impl $name {
            /// Writes the checksum. Call after all other fields are set.
            pub fn seal(&mut self) {
                self.crc32 = self.checksum();
            }

            /// Returns true if the checksum matches the content.
            #[must_use]
            pub fn is_intact(&self) -> bool {
                self.crc32 == self.checksum()
            }

            fn checksum(&self) -> u32 {
                let covered = core::mem::offset_of!($name, crc32);
                let mut hasher = crc32fast::Hasher::new();
                hasher.update(&self.as_bytes()[..covered]);
                hasher.finalize()
            }
        }
    };
}
pub(crate) use sealed;
