//! Errors of a configuration, one line per finding.

use std::fmt;
use std::path::PathBuf;

use atas_core::settings::present_name;

use super::TaskProblem;

/// Location of a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Location {
    /// File and line (from 1).
    File(PathBuf, usize),
    /// Command line.
    Flag,
}

/// Finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Problem {
    /// Unreadable file.
    Unreadable {
        /// File.
        path: PathBuf,
        /// Error of the operating system.
        why: String,
    },
    /// Invalid TOML.
    Syntax {
        /// Location.
        place: Location,
        /// Error of the parser.
        why: String,
    },
    /// Unknown key.
    UnknownKey {
        /// Location.
        place: Location,
        /// Key.
        key: String,
        /// Suggested key.
        meant: Option<&'static str>,
    },
    /// Value that is not permitted.
    InvalidValue {
        /// Location; `None` for a default value in conflict with another value.
        place: Option<Location>,
        /// Key.
        key: String,
        /// Value.
        value: String,
        /// Permitted values.
        needs: String,
    },
    /// Invalid user task.
    Task {
        /// Location.
        place: Location,
        /// Task name.
        name: String,
        /// Error.
        problem: TaskProblem,
    },
    /// Robot that does not load.
    Robot {
        /// Error of the loader.
        why: String,
    },
}

/// All findings of a rejected configuration, in the order of the files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConfigError(pub Vec<Problem>);

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path, line) => write!(f, "{}:{line}", path.display()),
            Self::Flag => f.write_str("--set"),
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable { path, why } => {
                write!(f, "{}: could not read the file: {why}", path.display())
            }
            Self::Syntax { place, why } => write!(f, "{place}: is not TOML: {why}"),
            Self::UnknownKey {
                place,
                key,
                meant: Some(meant),
            } if present_name(key) == Some(meant) => {
                write!(f, "{place}: {key} was renamed to {meant}; use the new name")
            }
            Self::UnknownKey {
                place,
                key,
                meant: Some(meant),
            } => {
                write!(f, "{place}: {key} is not a key; did you mean {meant}?")
            }
            Self::UnknownKey {
                place,
                key,
                meant: None,
            } => {
                write!(
                    f,
                    "{place}: {key} is not a key; `atasd --check-config` prints all keys"
                )
            }
            Self::InvalidValue {
                place: Some(place),
                key,
                value,
                needs,
            } => {
                write!(f, "{place}: {key} is {value}, needs {needs}")
            }
            Self::InvalidValue {
                place: None,
                key,
                value,
                needs,
            } => {
                write!(f, "{key} is {value} by default, needs {needs}")
            }
            Self::Task {
                place,
                name,
                problem,
            } => {
                write!(f, "{place}: tasks.{name}: ")?;
                if !problem.at.is_empty() {
                    write!(f, "{}: ", problem.at)?;
                }
                f.write_str(&problem.why)
            }
            Self::Robot { why } => write!(f, "robot.model: {why}"),
        }
    }
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("could not use the configuration:")?;
        self.0
            .iter()
            .try_for_each(|problem| write!(f, "\n  {problem}"))
    }
}

impl std::error::Error for ConfigError {}
