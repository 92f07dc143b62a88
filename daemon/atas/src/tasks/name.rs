//! Task and step names with fixed capacity.

use core::fmt;
use core::ops::Deref;

/// Name of at most [`Name::MAX`] bytes. Longer text is cut at a character boundary.
#[derive(Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Name {
    bytes: [u8; Self::MAX],
    length: usize,
}

impl Name {
    /// Maximum length, bytes; equals the capacity of [`shm_schemas::GoalUpdate::step`].
    pub const MAX: usize = 16;

    /// Creates a name.
    #[must_use]
    pub const fn new(text: &str) -> Self {
        let mut length = if text.len() < Self::MAX {
            text.len()
        } else {
            Self::MAX
        };
        while !text.is_char_boundary(length) {
            length -= 1;
        }
        let mut bytes = [0; Self::MAX];
        let mut i = 0;
        while i < length {
            bytes[i] = text.as_bytes()[i];
            i += 1;
        }
        Self { bytes, length }
    }

    /// Returns the text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        // Always valid: `new` cuts at a character boundary.
        core::str::from_utf8(&self.bytes[..self.length]).unwrap_or_default()
    }
}

impl Deref for Name {
    type Target = str;

    fn deref(&self) -> &str {
        self.as_str()
    }
}

impl PartialEq<&str> for Name {
    fn eq(&self, other: &&str) -> bool {
        self.as_str() == *other
    }
}

impl PartialEq<Name> for &str {
    fn eq(&self, other: &Name) -> bool {
        *self == other.as_str()
    }
}

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.as_str())
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}
