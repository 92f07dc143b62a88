//! The folder of a demo's logs, which is also how the next demo finds what a killed one left behind.

use std::fs::{self, DirBuilder};
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

use anyhow::Context;
use rustix::process::{Pid, geteuid, test_kill_process};
use shm_bus::{Bus, BusName};

/// What the folders are called in the folder for temporary files: this and the name of the bus.
const PREFIX: &str = "atas-demo-";
/// A file that is there until the demo has ended in good order. It contains the demo's process id.
const MARK: &str = "demo.pid";

/// A folder for logs: removed at the end unless they are worth reading.
pub(crate) struct Logs {
    pub(crate) folder: PathBuf,
    pub(crate) keep: bool,
}

impl Logs {
    /// A fresh folder, named after a fresh bus.
    pub(crate) fn new(bus: &BusName) -> anyhow::Result<Self> {
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
        // What cannot be removed now, the next demo removes.
        let _ = if self.keep {
            fs::remove_file(self.folder.join(MARK))
        } else {
            fs::remove_dir_all(&self.folder)
        };
    }
}

/// Removes bus and logs of this user's demos that were killed. What cannot be removed stays for the next time.
pub(crate) fn sweep() {
    let entries = fs::read_dir(std::env::temp_dir())
        .into_iter()
        .flatten()
        .flatten();
    for folder in entries.map(|entry| entry.path()) {
        let Some(bus) = bus_of(&folder) else { continue };
        if is_ours(&folder) && was_killed(&folder) && Bus::wipe(&bus).is_ok() {
            let _ = fs::remove_dir_all(&folder);
        }
    }
}

fn bus_of(folder: &Path) -> Option<BusName> {
    let name = folder.file_name()?.to_str()?;
    name.strip_prefix(PREFIX)?.parse().ok()
}

fn is_ours(folder: &Path) -> bool {
    fs::symlink_metadata(folder).is_ok_and(|meta| meta.is_dir() && meta.uid() == geteuid().as_raw())
}

/// Whether the mark names a process that is gone. A folder without a mark was kept on purpose.
fn was_killed(folder: &Path) -> bool {
    let mark = fs::read_to_string(folder.join(MARK)).unwrap_or_default();
    let pid = mark.parse().ok().and_then(Pid::from_raw);
    pid.is_some_and(|pid| test_kill_process(pid).is_err())
}
