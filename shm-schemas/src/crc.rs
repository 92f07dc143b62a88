//! Seals: a CRC-32 over a payload, against bit flips and torn writes.

/// Gives a payload whose last field is `crc32` the two ends of its seal.
macro_rules! sealed {
    ($name:ident) => {
        impl $name {
            /// Writes the checksum. Call last, after every other field is final.
            pub fn seal(&mut self) {
                self.crc32 = self.checksum();
            }

            /// Whether the content is what its writer sealed.
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
