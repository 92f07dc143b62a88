//! Errors of loading a robot.

use std::fmt;
use std::path::PathBuf;
use std::string::{String, ToString};
use std::vec;
use std::vec::Vec;

use atas_text_file::PROBLEMS_MAX;

use super::location::{element_line, word_line};
use crate::robot_file_parser::RobotFileErrors;

/// Error of loading a robot.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// A file could not be read.
    #[error("could not load the robot because {} was unreadable ({source}), needs a readable text file; check the path", .path.display())]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The name is neither a built-in robot nor a robot file.
    #[error(
        "could not load the robot {name:?} because no built-in robot has this name, needs one of \
         {known} or the path of a robot file (.toml); list them with `atas robot list`"
    )]
    Unknown {
        /// Requested name.
        name: String,
        /// Names of the built-in robots.
        known: String,
    },
    /// A URDF was given instead of a robot file. A URDF does not describe fingertips.
    #[error(
        "could not load the robot {0:?} because it is a URDF, needs a robot file (.toml) that \
         names this URDF; write one as the robot page of the guide shows"
    )]
    NoRobotFile(String),
    /// The text is not a URDF.
    #[error(
        "could not load the robot because its text was not a URDF ({0}), needs well-formed URDF; check the XML"
    )]
    Parse(#[from] urdf_rs::UrdfError),
    /// The robot file is invalid: all errors.
    #[error(transparent)]
    RobotFile(#[from] RobotFileErrors),
    /// The robot exceeds a limit or has unusable values: all problems.
    #[error("{}", lines(.0))]
    Problems(Vec<ModelProblem>),
}

/// One problem of a URDF or robot file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelProblem {
    /// Part of the URDF or of the robot file.
    pub item: String,
    /// Actual value.
    pub was: String,
    /// Required value.
    pub needs: String,
    /// File to change.
    pub file: ModelFile,
    /// Line of the part, counted from 1; `None` if it does not exist.
    pub line: Option<usize>,
}

/// File of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelFile {
    /// The URDF.
    Urdf,
    /// The robot file.
    RobotFile,
}

impl fmt::Display for ModelProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ModelProblem {
            item, was, needs, ..
        } = self;
        write!(
            f,
            "could not load the robot because {item} was {was}, needs {needs}; change "
        )?;
        if let Some(line) = self.line {
            write!(f, "line {line} of ")?;
        }
        f.write_str(match self.file {
            ModelFile::Urdf => "the URDF",
            ModelFile::RobotFile => "the robot file",
        })
    }
}

impl ModelProblem {
    /// Gives the line, from 1.
    pub(super) fn at_line(mut self, line: usize) -> Self {
        self.line = Some(line);
        self
    }

    /// Moves the problem to the robot file.
    pub(super) fn in_robot_file(mut self) -> Self {
        self.file = ModelFile::RobotFile;
        self
    }
}

impl From<ModelProblem> for ModelError {
    fn from(issue: ModelProblem) -> Self {
        Self::Problems(vec![issue])
    }
}

fn lines(problems: &[ModelProblem]) -> String {
    let lines: Vec<String> = problems.iter().map(ModelProblem::to_string).collect();
    lines.join("\n")
}

pub(crate) fn problem(
    item: impl ToString,
    was: impl ToString,
    needs: impl ToString,
) -> ModelProblem {
    ModelProblem {
        item: item.to_string(),
        was: was.to_string(),
        needs: needs.to_string(),
        file: ModelFile::Urdf,
        line: None,
    }
}

/// Problems found so far, and the texts for finding their lines.
#[derive(Debug)]
pub(super) struct Findings<'a> {
    problems: Vec<ModelProblem>,
    urdf: &'a str,
    robot_file: &'a str,
}

impl<'a> Findings<'a> {
    pub(super) fn new(urdf: &'a str, robot_file: &'a str) -> Self {
        Self {
            problems: Vec::new(),
            urdf,
            robot_file,
        }
    }

    /// Adds a problem once, with its line; ignores further ones beyond the limit.
    pub(super) fn add(&mut self, mut issue: ModelProblem) {
        if self.problems.len() >= PROBLEMS_MAX {
            return;
        }
        self.find(&mut issue);
        if !self.problems.contains(&issue) {
            self.problems.push(issue);
        }
    }

    /// Finds the line of the first part that a problem names: a link or joint of the URDF, else a
    /// word of the robot file.
    fn find(&self, issue: &mut ModelProblem) {
        let parts: Vec<&str> = issue.item.split('`').collect();
        let named = parts.chunks_exact(2).map(|pair| (pair[0], pair[1]));
        let in_urdf = |(before, name): (&str, &str)| {
            let kind = before.split_whitespace().next_back()?;
            let kind = if kind == "fingertip" { "link" } else { kind };
            element_line(self.urdf, kind, name)
        };
        if issue.file == ModelFile::Urdf {
            issue.line = named.clone().find_map(in_urdf);
            if issue.line.is_some() {
                return;
            }
        }
        issue.line = named
            .clone()
            .find_map(|(_, name)| word_line(self.robot_file, name))
            .or_else(|| {
                let is_missing = issue.item.ends_with(" in [joints]");
                is_missing.then(|| word_line(self.robot_file, "[joints]"))?
            });
        if issue.line.is_some() {
            issue.file = ModelFile::RobotFile;
        }
    }

    /// Returns the value, or adds the problem.
    pub(super) fn value_of<T>(&mut self, found: Result<T, ModelProblem>) -> Option<T> {
        found.map_err(|issue| self.add(issue)).ok()
    }

    /// Returns the result unless there are problems.
    pub(super) fn into_result<T>(self, whole: Option<T>) -> Result<T, ModelError> {
        match whole {
            Some(whole) if self.problems.is_empty() => Ok(whole),
            _ => Err(ModelError::Problems(self.problems)),
        }
    }
}
