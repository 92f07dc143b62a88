//! Log folder of a demo. A later demo uses it to find and remove the remains of a killed one.

use std::fs::{self, DirBuilder};
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

use anyhow::Context;
use rustix::process::{Pid, geteuid, test_kill_process};
use shm_bus::{Bus, BusName};

/// Prefix of folder names in the temporary folder; the bus name follows.
const PREFIX: &str = "atas-demo-";
/// File with the process id of the demo, present until the demo ends in order.
const MARK: &str = "demo.pid";

/// Log folder, removed at the end unless `keep` is set.
pub struct Logs {
    /// Path of the folder.
    pub folder: PathBuf,
    /// Keeps the folder after the end.
    pub keep: bool,
}

impl Logs {
    /// Creates the log folder of a bus, readable by this user only.
    ///
    /// # Errors
    /// The folder cannot be created.
    pub fn new(bus: &BusName) -> anyhow::Result<Self> {
        let folder = std::env::temp_dir().join(format!("{PREFIX}{bus}"));
        let made = DirBuilder::new().mode(0o700).create(&folder);
        made.and_then(|()| fs::write(folder.join(MARK), std::process::id().to_string()))
            .with_context(|| format!("could not make the log folder {}", folder.display()))?;
        Ok(Self {
            folder,
            keep: false,
        })
    }
}

impl Drop for Logs {
    fn drop(&mut self) {
        // If removal fails, the next demo tries again.
        let _ = if self.keep {
            fs::remove_file(self.folder.join(MARK))
        } else {
            fs::remove_dir_all(&self.folder)
        };
    }
}

/// Removes buses and logs of this user's killed demos. Failures are ignored; the next demo tries
/// again.
pub fn remove_stale() {
    let entries = fs::read_dir(std::env::temp_dir())
        .into_iter()
        .flatten()
        .flatten();
    for folder in entries.map(|entry| entry.path()) {
        let Some(bus) = bus_of(&folder) else { continue };
        if is_owned_by_user(&folder) && was_killed(&folder) && Bus::wipe(&bus).is_ok() {
            let _ = fs::remove_dir_all(&folder);
        }
    }
}

fn bus_of(folder: &Path) -> Option<BusName> {
    let name = folder.file_name()?.to_str()?;
    name.strip_prefix(PREFIX)?.parse().ok()
}

fn is_owned_by_user(folder: &Path) -> bool {
    fs::symlink_metadata(folder).is_ok_and(|meta| meta.is_dir() && meta.uid() == geteuid().as_raw())
}

/// Returns true if the process of the mark has ended. A folder without a mark was kept on purpose.
fn was_killed(folder: &Path) -> bool {
    let mark = fs::read_to_string(folder.join(MARK)).unwrap_or_default();
    let pid = mark.parse().ok().and_then(Pid::from_raw);
    pid.is_some_and(|pid| test_kill_process(pid).is_err())
}
