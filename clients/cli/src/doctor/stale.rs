//! Shared memory of buses that no process uses: the remains of killed processes.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::ErrorKind;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use super::checks;
use super::root::Root;

pub(super) const SHM: &str = "dev/shm";

/// Files of one bus in `/dev/shm` that no process maps.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Remains {
    pub(super) files: Vec<PathBuf>,
    pub(super) bytes: u64,
}

/// Reason why a process may use a file unseen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Doubt {
    /// Processes outside this container are not listed. The locks of a bus may not show them.
    Container,
    /// A process of this user hides its memory. The locks of a bus show it.
    HiddenMemory,
}

impl Doubt {
    pub(super) fn reason(self) -> &'static str {
        match self {
            Self::Container => "processes outside this container are not visible",
            Self::HiddenMemory => "a process of this user hides its memory",
        }
    }
}

/// Unused shared memory of one user.
#[derive(Clone, Debug, Default)]
pub(super) struct Stale {
    /// Remains by bus name.
    pub(super) buses: BTreeMap<String, Remains>,
    pub(super) doubt: Option<Doubt>,
}

impl Stale {
    /// Finds the unused shared memory of this user.
    pub(super) fn find(root: &Root, user: u32) -> Self {
        let mut buses = bus_files(root, user);
        // Read after the files: a bus under creation then counts as used.
        let mapped = Mapped::read(root, user);
        buses.retain(|bus, _| !mapped.buses.contains(bus));
        Self {
            buses,
            doubt: mapped.doubt,
        }
    }

    /// Returns the unused bytes by bus name.
    pub(super) fn bytes(&self) -> BTreeMap<String, u64> {
        let buses = self.buses.iter();
        buses
            .map(|(bus, remains)| (bus.clone(), remains.bytes))
            .collect()
    }

    /// Returns true if a bus has files but no visible process.
    pub(super) fn is_abandoned(&self, bus: &str) -> bool {
        self.doubt != Some(Doubt::Container) && self.buses.contains_key(bus)
    }
}

/// Returns the files of this user in `/dev/shm` by bus name.
fn bus_files(root: &Root, user: u32) -> BTreeMap<String, Remains> {
    let mut buses = BTreeMap::<String, Remains>::new();
    for path in root.entries(SHM) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let Some(bus) = checks::bus_of_file(&name) else {
            continue;
        };
        // Links are not followed.
        let Ok(meta) = fs::symlink_metadata(&path) else {
            continue;
        };
        if meta.is_file() && meta.uid() == user {
            let remains = buses.entry(bus.to_owned()).or_default();
            remains.bytes += meta.blocks() * 512;
            remains.files.push(path);
        }
    }
    buses
}

/// Buses whose shared memory a process maps.
#[derive(Default)]
struct Mapped {
    buses: BTreeSet<String>,
    doubt: Option<Doubt>,
}

impl Mapped {
    fn read(root: &Root, user: u32) -> Self {
        let mut mapped = Self::default();
        if !root.lists_all_processes() {
            mapped.doubt = Some(Doubt::Container);
        }
        for process in root.processes() {
            match fs::read_to_string(process.join("maps")) {
                Ok(maps) => mapped.buses.extend(buses_of_maps(&maps)),
                Err(error) if error.kind() == ErrorKind::PermissionDenied => {
                    if belongs_to(&process, user) {
                        mapped.doubt = mapped.doubt.or(Some(Doubt::HiddenMemory));
                    }
                }
                // The process has ended.
                Err(_) => {}
            }
        }
        mapped
    }
}

/// Returns the buses in `/proc/PID/maps`.
fn buses_of_maps(maps: &str) -> BTreeSet<String> {
    let files = maps.lines().filter_map(|line| line.split_once("/dev/shm/"));
    files
        .filter_map(|(_, file)| checks::bus_of_file(file))
        .map(str::to_owned)
        .collect()
}

/// Returns true if a process runs as a user. If it hides its memory, root owns its folder.
fn belongs_to(process: &Path, user: u32) -> bool {
    let status = fs::read_to_string(process.join("status")).unwrap_or_default();
    let users = status.lines().find_map(|line| line.strip_prefix("Uid:"));
    let user = user.to_string();
    users.is_some_and(|users| users.split_whitespace().any(|word| word == user))
}

#[cfg(test)]
pub(super) mod tests;
