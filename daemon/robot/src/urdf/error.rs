//! Why a robot was not loaded.

use std::fmt;
use std::format;
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
    /// The file in which to change it.
    pub file: ModelFile,
    /// The line there at which what it names is, counted from 1; `None` if it names nothing that is there.
    pub line: Option<usize>,
}

/// One of the two files that a robot is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelFile {
    /// The URDF.
    Urdf,
    /// The robot file.
    RobotFile,
}

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Misfit {
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

impl Misfit {
    /// The same, of something that the robot file says.
    pub(super) fn of_robot_file(mut self) -> Self {
        self.file = ModelFile::RobotFile;
        self
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
        file: ModelFile::Urdf,
        line: None,
    }
}

/// Everything that was found wrong so far, and the texts in which its places are looked up.
#[derive(Debug)]
pub(super) struct Findings<'a> {
    misfits: Vec<Misfit>,
    urdf: &'a str,
    robot_file: &'a str,
}

impl<'a> Findings<'a> {
    pub(super) fn new(urdf: &'a str, robot_file: &'a str) -> Self {
        Self {
            misfits: Vec::new(),
            urdf,
            robot_file,
        }
    }

    /// Notes what is wrong, once, with its place.
    pub(super) fn add(&mut self, mut misfit: Misfit) {
        self.find(&mut misfit);
        if !self.misfits.contains(&misfit) {
            self.misfits.push(misfit);
        }
    }

    /// The line of the first thing that a misfit names in its file; what the URDF has not got is what the robot file speaks of.
    fn find(&self, misfit: &mut Misfit) {
        let names: Vec<&str> = misfit.item.split('`').skip(1).step_by(2).collect();
        let line_of = |text: &str, form: &dyn Fn(&str) -> String| {
            let forms: Vec<String> = names.iter().map(|name| form(name)).collect();
            let lines = text.lines().enumerate();
            let holds = |line: &str| forms.iter().any(|form| line.contains(form));
            let mut found = lines.filter(|(_, line)| holds(line));
            found.next().map(|(index, _)| index + 1)
        };
        let in_urdf = || line_of(self.urdf, &|name| format!("name=\"{name}\""));
        let in_robot_file = || line_of(self.robot_file, &|name| name.to_string());
        if misfit.file == ModelFile::Urdf {
            misfit.line = in_urdf();
            if misfit.line.is_some() {
                return;
            }
        }
        misfit.line = in_robot_file();
        if misfit.line.is_some() {
            misfit.file = ModelFile::RobotFile;
        }
    }

    /// The value, or a note of why there is none.
    pub(super) fn note<T>(&mut self, found: Result<T, Misfit>) -> Option<T> {
        found.map_err(|misfit| self.add(misfit)).ok()
    }

    /// The whole, unless something was wrong.
    pub(super) fn unless_any<T>(self, whole: Option<T>) -> Result<T, ModelError> {
        match whole {
            Some(whole) if self.misfits.is_empty() => Ok(whole),
            _ => Err(ModelError::Misfits(self.misfits)),
        }
    }
}
