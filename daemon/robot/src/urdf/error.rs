//! Why a robot was not loaded.

use std::path::PathBuf;
use std::string::{String, ToString};

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
    /// The text is not a URDF.
    #[error(
        "could not load the robot because its text was not a URDF ({0}), needs well-formed URDF; check the XML"
    )]
    Parse(#[from] urdf_rs::UrdfError),
    /// The robot is not of the structure that the controller is made for, or a number in it is unusable.
    #[error("could not load the robot because {item} was {was}, needs {needs}; change the URDF")]
    Misfit {
        /// The part of the URDF.
        item: String,
        /// What it was.
        was: String,
        /// What is needed instead.
        needs: String,
    },
}

pub(crate) fn misfit(item: impl ToString, was: impl ToString, needs: impl ToString) -> ModelError {
    ModelError::Misfit {
        item: item.to_string(),
        was: was.to_string(),
        needs: needs.to_string(),
    }
}
