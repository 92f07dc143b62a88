//! Why a robot was not loaded.

use std::fmt;
use std::path::PathBuf;
use std::string::{String, ToString};
use std::vec;
use std::vec::Vec;

/// Why a robot was not loaded.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// The file could not be read.
    #[error("could not load the robot because {} was unreadable ({source}), needs a readable text file; check the path", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// No robot of this name ships, and it is no robot file.
    #[error(
        "could not load the robot {name:?} because no robot of this name ships, needs one of {known} or the path of a robot file (.toml); `atas robot list` shows them"
    )]
    Unknown {
        /// What was asked for.
        name: String,
        /// The names of those that ship.
        known: String,
    },
    /// A URDF alone does not say where the fingertips are.
    #[error(
        "could not load the robot {0:?} because it is a URDF, needs the robot file (.toml) that names it; write one: `atas robot check` tells what is missing"
    )]
    NoRobotFile(String),
    /// The text is not a URDF.
    #[error(
        "could not load the robot because its text was not a URDF ({0}), needs well-formed URDF; check the XML"
    )]
    Parse(#[from] urdf_rs::UrdfError),
    /// The robot file is not what it has to be.
    #[error(
        "could not load the robot because its robot file was not understood ({0}); correct it there"
    )]
    RobotFile(#[from] toml::de::Error),
    /// The robot is beyond the bounds that the controller is made for, or something in it is unusable: all that was found.
    #[error("{}", lines(.0))]
    Misfits(Vec<Misfit>),
}

/// One thing that does not fit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Misfit {
    /// The part of the URDF or of the robot file.
    pub item: String,
    /// What it was.
    pub was: String,
    /// What is needed instead.
    pub needs: String,
}

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Misfit { item, was, needs } = self;
        write!(
            f,
            "could not load the robot because {item} was {was}, needs {needs}; change the URDF or its robot file"
        )
    }
}

impl From<Misfit> for ModelError {
    fn from(misfit: Misfit) -> Self {
        Self::Misfits(vec![misfit])
    }
}

fn lines(misfits: &[Misfit]) -> String {
    let lines: Vec<String> = misfits.iter().map(Misfit::to_string).collect();
    lines.join("\n")
}

pub(crate) fn misfit(item: impl ToString, was: impl ToString, needs: impl ToString) -> Misfit {
    Misfit {
        item: item.to_string(),
        was: was.to_string(),
        needs: needs.to_string(),
    }
}

/// Everything that was found wrong so far.
#[derive(Debug, Default)]
pub(super) struct Findings(Vec<Misfit>);

impl Findings {
    /// Notes what is wrong, once.
    pub(super) fn add(&mut self, misfit: Misfit) {
        if !self.0.contains(&misfit) {
            self.0.push(misfit);
        }
    }

    /// The value, or a note of why there is none.
    pub(super) fn note<T>(&mut self, found: Result<T, Misfit>) -> Option<T> {
        found.map_err(|misfit| self.add(misfit)).ok()
    }

    /// The whole, unless something was wrong.
    pub(super) fn unless_any<T>(self, whole: Option<T>) -> Result<T, ModelError> {
        match whole {
            Some(whole) if self.0.is_empty() => Ok(whole),
            _ => Err(ModelError::Misfits(self.0)),
        }
    }
}
