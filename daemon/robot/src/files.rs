//! Texts of a robot (URDF and robot file): built-in ones, and others by the path of a robot file.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::string::{String, ToString};
use std::vec::Vec;

use shm_schemas::layout::{FNV_OFFSET, fnv1a};

use crate::robot::RobotModel;
use crate::robot_file::RobotFile;
use crate::urdf::{ModelError, remarks};

/// URDF and robot file of a robot, with its name for users.
///
/// ```
/// use robot_model::RobotFiles;
///
/// let files = RobotFiles::find("two-hand-arm")?;
/// assert_eq!(files.load()?.joint_count(), 22);
/// assert!(RobotFiles::find("no-such-robot").is_err());
/// # Ok::<(), robot_model::ModelError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotFiles {
    /// Name of a built-in robot, or path of a robot file: the value of `--robot`.
    pub name: Cow<'static, str>,
    /// Text of its URDF.
    pub urdf: Cow<'static, str>,
    /// Text of its robot file.
    pub robot_file: Cow<'static, str>,
}

macro_rules! shipped {
    ($name:literal) => {
        RobotFiles {
            name: Cow::Borrowed($name),
            urdf: Cow::Borrowed(include_str!(concat!("../robots/", $name, "/robot.urdf"))),
            robot_file: Cow::Borrowed(include_str!(concat!("../robots/", $name, "/robot.toml"))),
        }
    };
}

/// Two-hand arm of the paper, the default.
pub const TWO_HAND_ARM: RobotFiles = shipped!("two-hand-arm");

/// Built-in robots, the default first.
pub const SHIPPED: [RobotFiles; 4] = [
    TWO_HAND_ARM,
    shipped!("arm7-gripper"),
    shipped!("three-finger"),
    shipped!("test-bench"),
];

impl RobotFiles {
    /// Finds a built-in robot by name, or another by the path of its robot file. The robot file
    /// names its URDF, or the URDF has the same name with the extension `.urdf`.
    ///
    /// # Errors
    /// [`ModelError`] if there is none of this name, or its files cannot be read.
    pub fn find(robot: &str) -> Result<Self, ModelError> {
        let shipped = SHIPPED.into_iter().find(|shipped| shipped.name == robot);
        if let Some(shipped) = shipped {
            return Ok(shipped);
        }
        let path = Path::new(robot);
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("toml") => Self::read(path),
            Some("urdf" | "xml" | "xacro") => Err(ModelError::NoRobotFile(robot.into())),
            _ => Err(ModelError::Unknown {
                name: robot.into(),
                known: shipped_names().collect::<Vec<_>>().join(", "),
            }),
        }
    }

    fn read(path: &Path) -> Result<Self, ModelError> {
        let robot_file = text(path.to_path_buf())?;
        let urdf = urdf_path(path, &robot_file)?;
        Ok(Self {
            name: Cow::Owned(path.display().to_string()),
            urdf: Cow::Owned(text(urdf)?),
            robot_file: Cow::Owned(robot_file),
        })
    }

    /// Returns the path of the URDF; `None` for a built-in robot.
    #[must_use]
    pub fn urdf_path(&self) -> Option<PathBuf> {
        let path = Path::new(&*self.name);
        path.extension()?;
        urdf_path(path, &self.robot_file).ok()
    }

    /// Returns the FNV-1a 64 hash of both texts, which distinguishes recordings of different
    /// robots.
    #[must_use]
    pub fn hash(&self) -> u64 {
        let urdf = fnv1a(FNV_OFFSET, self.urdf.as_bytes());
        fnv1a(urdf, self.robot_file.as_bytes())
    }

    /// Returns one sentence for each collision shape that was ignored or approximated.
    pub fn remarks(&self) -> Result<Vec<String>, ModelError> {
        remarks(&self.urdf, &self.robot_file)
    }

    /// Loads the robot.
    pub fn load(&self) -> Result<RobotModel, ModelError> {
        RobotModel::load(&self.urdf, &self.robot_file)
    }
}

/// Returns the path of the URDF of a robot file at `path`.
fn urdf_path(path: &Path, robot_file: &str) -> Result<PathBuf, ModelError> {
    let named = RobotFile::parse(robot_file)?.urdf;
    Ok(named.map_or_else(
        || path.with_extension("urdf"),
        |urdf| path.with_file_name(urdf),
    ))
}

/// Returns the names of the built-in robots, the default first.
pub fn shipped_names() -> impl Iterator<Item = String> {
    SHIPPED.into_iter().map(|shipped| shipped.name.to_string())
}

fn text(path: PathBuf) -> Result<String, ModelError> {
    atas_text_file::read(&path).map_err(|source| ModelError::Read { path, source })
}

impl RobotModel {
    /// Loads the robot of the paper.
    pub fn two_hand_arm() -> Result<RobotModel, ModelError> {
        TWO_HAND_ARM.load()
    }

    /// Loads the robot with this name or robot file; see [`RobotFiles::find`].
    pub fn find(robot: &str) -> Result<RobotModel, ModelError> {
        RobotFiles::find(robot)?.load()
    }
}
