//! The system's configuration: where it is, and the one key that two programs read, the daemon to check it and the gate to go by it.

use std::fmt;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// The system's configuration: this file, then every `*.toml` of the folder.
pub const SYSTEM_FILE: &str = "/etc/atas/atas.toml";
/// See [`SYSTEM_FILE`].
pub const SYSTEM_FOLDER: &str = "/etc/atas/conf.d";

/// The files of the system's configuration that there are, in the order in which later ones win.
///
/// # Errors
/// The folder is there and cannot be read.
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

/// `access.group`: what members of the service's group may do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GroupRight {
    /// Nothing, not even to stop.
    None,
    /// Look on, and stop the robot.
    #[default]
    Observe,
    /// Everything that touches no files of their own.
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
