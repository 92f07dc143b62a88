//! Users of the operating system.

use std::fmt;

/// User of the machine; prints its name, or its number if it has none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct User(pub(crate) u32);

pub(crate) fn uid() -> u32 {
    rustix::process::geteuid().as_raw()
}

impl fmt::Display for User {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match nix::unistd::User::from_uid(self.0.into()) {
            Ok(Some(user)) => f.write_str(&user.name),
            _ => write!(f, "{}", self.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::User;

    #[test]
    fn user_prints_as_name_or_number() {
        assert_eq!(User(0).to_string(), "root");
        assert_eq!(User(u32::MAX - 7).to_string(), "4294967288");
    }
}
