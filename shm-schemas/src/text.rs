//! Text of fixed capacity.

use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// UTF-8 text of up to `N` bytes, zero-filled. Longer text is cut at a character boundary.
#[repr(C)]
#[derive(
    Clone, Copy, PartialEq, Eq, ZeroCopySend, FromBytes, IntoBytes, Immutable, KnownLayout,
)]
#[type_name("atas.Text.v1")]
pub struct Text<const N: usize>(
    /// Bytes; the text ends at the first zero.
    pub [u8; N],
);

impl<const N: usize> Text<N> {
    /// Creates text from a string, cut to the capacity.
    ///
    /// ```
    /// # use shm_schemas::Text;
    /// let step: Text<16> = Text::new("lift");
    /// assert_eq!(step.as_str(), "lift");
    /// ```
    #[must_use]
    pub fn new(text: &str) -> Self {
        let mut end = text.len().min(N);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        let mut bytes = [0; N];
        bytes[..end].copy_from_slice(&text.as_bytes()[..end]);
        Self(bytes)
    }

    /// Returns the text. Invalid UTF-8 reads as empty, because bytes from the bus may have any
    /// value.
    #[must_use]
    pub fn as_str(&self) -> &str {
        let end = self.0.iter().position(|&b| b == 0).unwrap_or(N);
        core::str::from_utf8(&self.0[..end]).unwrap_or("")
    }
}

#[cfg(feature = "serde")]
crate::bytes::as_bytes!(Text<const N: usize>);

impl<const N: usize> Default for Text<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

impl<const N: usize> core::fmt::Debug for Text<N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:?}", self.as_str())
    }
}

impl<const N: usize> core::fmt::Display for Text<N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(self.as_str())
    }
}
