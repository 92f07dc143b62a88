//! The robots that ship, and loading what replaces the default.

#[cfg(feature = "std")]
use std::path::Path;

#[cfg(feature = "std")]
use crate::model::RobotModel;
#[cfg(feature = "std")]
use crate::urdf::ModelError;

/// A robot that ships: its files.
#[derive(Clone, Copy, Debug)]
pub struct BuiltIn {
    /// Its name, as `--robot` takes it.
    pub name: &'static str,
    /// Text of its URDF.
    pub urdf: &'static str,
    /// Text of its robot file.
    pub robot_file: &'static str,
}

/// The paper's two-hand arm, the default.
pub const TWO_HAND_ARM: BuiltIn = BuiltIn {
    name: "two-hand-arm",
    urdf: include_str!("../robots/two-hand-arm/robot.urdf"),
    robot_file: include_str!("../robots/two-hand-arm/robot.toml"),
};

#[cfg(feature = "std")]
impl BuiltIn {
    /// Loads it.
    ///
    /// # Errors
    /// None in a released crate: a test loads every one.
    pub fn load(&self) -> Result<RobotModel, ModelError> {
        RobotModel::load(self.urdf, self.robot_file)
    }
}

#[cfg(feature = "std")]
impl RobotModel {
    /// The paper's robot.
    ///
    /// # Errors
    /// None in a released crate: a test loads it.
    pub fn two_hand_arm() -> Result<RobotModel, ModelError> {
        TWO_HAND_ARM.load()
    }

    /// Loads a robot of the two-hand arm's joints and fingertips, with its robot file, from the text of another URDF.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn from_urdf(text: &str) -> Result<RobotModel, ModelError> {
        RobotModel::load(text, TWO_HAND_ARM.robot_file)
    }

    /// [`from_urdf`](Self::from_urdf) with the text of a file.
    ///
    /// # Errors
    /// [`ModelError`] if the file cannot be read, and as [`load`](Self::load).
    pub fn from_urdf_file(path: impl AsRef<Path>) -> Result<RobotModel, ModelError> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|source| ModelError::Read {
            path: path.to_path_buf(),
            source,
        })?;
        RobotModel::from_urdf(&text)
    }
}
