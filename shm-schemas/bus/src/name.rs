//! Name of a bus.

use std::fmt;
use std::str::FromStr;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::error::BusError;

/// Maximum length, bytes. Together with the longest folder it keeps iceoryx2's event sockets below
/// the 108 bytes of a socket address. Design choice.
const NAME_MAX: usize = 24;

/// Bus name: 1 to 24 characters out of `a-z`, `0-9` and `-`, with no `-` first or last.
///
/// It determines the bus's folder. Parse it from `--bus` or read it
/// [from the environment](BusName::from_env).
///
/// ```
/// # use shm_bus::BusName;
/// assert!("lab-1".parse::<BusName>().is_ok());
/// assert!("../lab".parse::<BusName>().is_err());
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct BusName(String);

impl BusName {
    /// Environment variable with the bus name.
    pub const ENV: &'static str = "ATAS_BUS";

    /// The name in `ATAS_BUS`; `atas` if it is not set.
    ///
    /// # Errors
    /// [`BusError::Name`] if `ATAS_BUS` is not a valid name.
    pub fn from_env() -> Result<Self, BusError> {
        match std::env::var_os(Self::ENV) {
            None => Ok(Self::default()),
            Some(value) => value.to_string_lossy().parse(),
        }
    }

    /// Unique name on this machine during the life of this process, for tests and demos. Uses the
    /// first 8 letters and digits of `label`.
    #[must_use]
    pub fn fresh(label: &str) -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let label: String = label
            .chars()
            .filter(|c| matches!(c, 'a'..='z' | '0'..='9'))
            .take(8)
            .collect();
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        // At most 1 + 8 + 1 + 7 + 1 + 4 characters; process ids have at most 7 digits
        // (PID_MAX_LIMIT).
        Self(format!(
            "f{label}-{}-{:x}",
            std::process::id(),
            count & 0xffff
        ))
    }

    /// The name as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl Default for BusName {
    fn default() -> Self {
        Self("atas".to_owned())
    }
}

impl FromStr for BusName {
    type Err = BusError;

    fn from_str(text: &str) -> Result<Self, BusError> {
        let allowed = |c: char| matches!(c, 'a'..='z' | '0'..='9' | '-');
        let why = match text {
            "" => "it is empty",
            _ if text.len() > NAME_MAX => "it is longer than 24 bytes",
            _ if !text.chars().all(allowed) => "it contains a forbidden character",
            _ if text.starts_with('-') || text.ends_with('-') => "it begins or ends with '-'",
            _ => return Ok(Self(text.to_owned())),
        };
        Err(BusError::Name {
            name: text.chars().take(2 * NAME_MAX).collect(),
            why,
        })
    }
}

impl fmt::Display for BusName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::BusName;

    fn check(name: &str, valid: bool) {
        let parsed = name.parse::<BusName>();
        assert_eq!(parsed.is_ok(), valid, "{name:?} gave {parsed:?}");
    }

    #[test]
    fn bus_names_are_validated() {
        check("atas", true);
        check("a", true);
        check("0", true);
        check("left-arm-2", true);
        check(&"a".repeat(24), true);
        check("", false);
        check(&"a".repeat(25), false);
        check("-a", false);
        check("a-", false);
        check("Atas", false);
        check("a_b", false);
        check("a b", false);
        check("a/b", false);
        check("..", false);
        check("a\0", false);
        check("ä", false);
        check("a\n", false);
    }

    #[test]
    fn fresh_names_are_valid_and_differ() {
        let names = ["", "test", "A very long Label, with marks!", "ä"].map(BusName::fresh);
        for (i, name) in names.iter().enumerate() {
            check(name.as_str(), true);
            assert!(!names[..i].contains(name));
        }
    }
}
