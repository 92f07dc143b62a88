//! What is wrong with a configuration, one line per finding.

use std::fmt;
use std::path::PathBuf;

use super::TaskProblem;

/// Where a value was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// In a file, on a line (from 1).
    File(PathBuf, usize),
    /// On the command line.
    Flag,
}

/// One finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Problem {
    /// A file could not be read.
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        why: String,
    },
    /// A text is not TOML.
    Syntax {
        /// Where.
        place: Place,
        /// What the parser said.
        why: String,
    },
    /// No such key.
    UnknownKey {
        /// Where.
        place: Place,
        /// The key.
        key: String,
        /// The key that was probably meant.
        meant: Option<&'static str>,
    },
    /// A value that the key cannot have.
    Value {
        /// Where; `None` if the value is a default that another value contradicts.
        place: Option<Place>,
        /// The key.
        key: String,
        /// The value.
        value: String,
        /// What it needs to be.
        needs: String,
    },
    /// One of the user's own tasks.
    Task {
        /// Where.
        place: Place,
        /// Its name.
        name: String,
        /// What is wrong.
        problem: TaskProblem,
    },
    /// The URDF does not load.
    Robot {
        /// What the loader said.
        why: String,
    },
}

/// Why a configuration was refused: every finding, in the order of the files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConfigError(pub Vec<Problem>);

impl fmt::Display for Place {
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
                write!(f, "{}: could not read it because of: {why}", path.display())
            }
            Self::Syntax { place, why } => write!(f, "{place}: is not TOML: {why}"),
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
            Self::Value {
                place: Some(place),
                key,
                value,
                needs,
            } => {
                write!(f, "{place}: {key} is {value}, needs {needs}")
            }
            Self::Value {
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
