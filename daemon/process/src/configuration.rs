//! Locations of the system configuration, and the key `access.group`, which the daemon validates
//! and the gate applies.

use std::fmt;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// Main file of the system configuration, read before the `*.toml` files of [`SYSTEM_FOLDER`].
pub const SYSTEM_FILE: &str = "/etc/atas/atas.toml";
/// Folder with additional configuration files.
pub const SYSTEM_FOLDER: &str = "/etc/atas/conf.d";

/// Returns the existing files of the system configuration; later files override earlier ones.
///
/// # Errors
/// The folder exists but cannot be read.
pub fn system_files() -> io::Result<Vec<PathBuf>> {
    let mut parts = Vec::new();
    match fs::read_dir(SYSTEM_FOLDER) {
        Ok(entries) => {
            for entry in entries {
                parts.push(entry?.path());
            }
        }
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    parts.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    parts.sort();
    let main = PathBuf::from(SYSTEM_FILE);
    let exists = !matches!(fs::metadata(&main), Err(e) if e.kind() == ErrorKind::NotFound);
    Ok(exists.then_some(main).into_iter().chain(parts).collect())
}

/// Permissions of the members of the service group (`access.group`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GroupRight {
    /// No access, not even to stop.
    None,
    /// Observe and stop the robot.
    #[default]
    Observe,
    /// Every operation except those on the members' own files.
    Command,
}

impl fmt::Display for GroupRight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::None => "none",
            Self::Observe => "observe",
            Self::Command => "command",
        })
    }
}
