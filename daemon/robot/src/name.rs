//! Names from a URDF in fixed memory.

use core::fmt;
use core::ops::Deref;

/// Longest name, bytes of UTF-8. Design choice.
pub const NAME_MAX: usize = 48;

/// Name of a joint or link; dereferences to text.
///
/// ```
/// use robot_model::Name;
///
/// let name = Name::new("finger1_tip").expect("short enough");
/// assert_eq!(name.as_str(), "finger1_tip");
/// assert!(Name::new(&"x".repeat(100)).is_none());
/// ```
#[derive(Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Name {
    /// Zero beyond `length`.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    bytes: [u8; NAME_MAX],
    length: usize,
}

impl Name {
    /// Returns `None` if the name is longer than [`NAME_MAX`].
    #[must_use]
    pub fn new(text: &str) -> Option<Self> {
        let mut bytes = [0; NAME_MAX];
        bytes
            .get_mut(..text.len())?
            .copy_from_slice(text.as_bytes());
        Some(Self {
            bytes,
            length: text.len(),
        })
    }

    /// Returns the text; empty if it is not UTF-8.
    #[must_use]
    pub fn as_str(&self) -> &str {
        let bytes = self.bytes.get(..self.length).unwrap_or_default();
        core::str::from_utf8(bytes).unwrap_or_default()
    }
}

impl Default for Name {
    /// Empty name.
    fn default() -> Self {
        Self {
            bytes: [0; NAME_MAX],
            length: 0,
        }
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

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.as_str())
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self)
    }
}
