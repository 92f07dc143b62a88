//! Kernel files below a root folder: `/` on a real machine, another folder in tests.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use super::checks::Interrupt;

/// Inode of the first PID namespace (`PROC_PID_INIT_INO` of the kernel).
const FIRST_PID_NAMESPACE: &str = "pid:[4026531836]";
const CORES: &str = "sys/devices/system/cpu";
const CONTROL_GROUPS: &str = "sys/fs/cgroup";

/// Root folder of all files that the checks read.
#[derive(Clone, Debug)]
pub(super) struct Root(PathBuf);

impl Root {
    pub(super) fn new(folder: impl Into<PathBuf>) -> Self {
        Self(folder.into())
    }

    /// Returns the path of a file, given relative to the root.
    pub(super) fn path(&self, file: impl AsRef<Path>) -> PathBuf {
        self.0.join(file)
    }

    /// Returns the content of a file; empty if it cannot be read.
    pub(super) fn read(&self, file: impl AsRef<Path>) -> String {
        fs::read_to_string(self.path(file)).unwrap_or_default()
    }

    pub(super) fn exists(&self, file: impl AsRef<Path>) -> bool {
        self.path(file).exists()
    }

    /// Returns the owner of a file.
    pub(super) fn owner(&self, file: impl AsRef<Path>) -> Option<u32> {
        fs::metadata(self.path(file)).ok().map(|meta| meta.uid())
    }

    /// Returns the entries of a folder in a fixed order; none if it cannot be read.
    pub(super) fn entries(&self, folder: impl AsRef<Path>) -> Vec<PathBuf> {
        let entries = fs::read_dir(self.path(folder)).into_iter().flatten();
        let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        paths.sort();
        paths
    }

    /// Returns the existing files of this name in the frequency folders of all cores.
    pub(super) fn frequency_files(&self, name: &str) -> Vec<PathBuf> {
        let files = self.entries(CORES).into_iter();
        files
            .map(|core| core.join("cpufreq").join(name))
            .filter(|file| file.is_file())
            .collect()
    }

    /// Returns the contents of the files of this name in the frequency folders of all cores.
    pub(super) fn frequency_settings(&self, name: &str) -> Vec<String> {
        let files = self.frequency_files(name).into_iter();
        files
            .filter_map(|file| fs::read_to_string(file).ok())
            .collect()
    }

    /// Returns a core list such as `isolated` or `present`.
    pub(super) fn cores(&self, kind: &str) -> String {
        self.read(Path::new(CORES).join(kind))
    }

    /// Returns the interrupts with a handler, with the cores that serve them.
    pub(super) fn interrupts(&self) -> Vec<Interrupt> {
        let interrupts = self.entries("proc/irq").into_iter();
        interrupts.filter_map(|folder| interrupt(&folder)).collect()
    }

    /// Returns true if a battery of the computer supplies it. Batteries of mice do not count.
    pub(super) fn is_on_battery(&self) -> bool {
        let supplies = self.entries("sys/class/power_supply");
        supplies.iter().any(|supply| {
            let is = |file: &str, value: &str| read(&supply.join(file)).trim() == value;
            is("type", "Battery") && is("status", "Discharging") && !is("scope", "Device")
        })
    }

    /// Returns the kind of container of this process, if any.
    pub(super) fn container(&self) -> Option<String> {
        let named = self.read("run/systemd/container").trim().to_owned();
        if !named.is_empty() {
            return Some(named);
        }
        let marks = [(".dockerenv", "docker"), ("run/.containerenv", "podman")];
        let mark = marks.iter().find(|(file, _)| self.exists(file));
        mark.map(|(_, kind)| (*kind).to_owned())
    }

    /// Returns a setting of the control group of this process and of all groups above it.
    pub(super) fn control_group_settings(&self, name: &str) -> Vec<String> {
        let groups = self.read("proc/self/cgroup");
        let group = groups.lines().find_map(|line| line.strip_prefix("0::/"));
        let folder = Path::new(CONTROL_GROUPS);
        let Some(group) = group.filter(|group| !group.contains("..")) else {
            return Vec::new();
        };
        let groups = Path::new(group).ancestors();
        let settings = groups.map(|group| self.read(folder.join(group).join(name)));
        settings.filter(|text| !text.is_empty()).collect()
    }

    /// Returns the processor time limits of all control groups, as `QUOTA PERIOD` in µs.
    pub(super) fn processor_quotas(&self) -> Vec<String> {
        let mut quotas = self.control_group_settings("cpu.max");
        // cgroup v1.
        let old = |file: &str| self.read(Path::new(CONTROL_GROUPS).join("cpu").join(file));
        let quota = old("cpu.cfs_quota_us");
        if !quota.is_empty() {
            quotas.push(format!(
                "{} {}",
                quota.trim(),
                old("cpu.cfs_period_us").trim()
            ));
        }
        quotas
    }

    /// Returns true if `/proc` lists every process of the computer. In a container it does not.
    pub(super) fn lists_all_processes(&self) -> bool {
        let namespace = fs::read_link(self.path("proc/self/ns/pid"));
        namespace.is_ok_and(|namespace| namespace == Path::new(FIRST_PID_NAMESPACE))
    }

    /// Returns the folders of all processes in `/proc`.
    pub(super) fn processes(&self) -> Vec<PathBuf> {
        let mut folders = self.entries("proc");
        folders.retain(|folder| number(folder).is_some());
        folders
    }

    /// Returns true if the program file of a process was removed or replaced.
    pub(super) fn is_replaced(&self, pid: u32) -> bool {
        let program = fs::read_link(self.path(format!("proc/{pid}/exe")));
        program.is_ok_and(|program| program.to_string_lossy().ends_with(" (deleted)"))
    }
}

fn read(file: &Path) -> String {
    fs::read_to_string(file).unwrap_or_default()
}

/// Returns the number that names a file or folder.
fn number(path: &Path) -> Option<u32> {
    path.file_name()?.to_str()?.parse().ok()
}

/// Reads the folder of an interrupt. Its subfolders are named after its handlers.
fn interrupt(folder: &Path) -> Option<Interrupt> {
    let number = number(folder)?;
    let mut entries = fs::read_dir(folder).ok()?.flatten();
    if !entries.any(|entry| entry.path().is_dir()) {
        return None;
    }
    let effective = read(&folder.join("effective_affinity_list"));
    let cores = if effective.trim().is_empty() {
        read(&folder.join("smp_affinity_list"))
    } else {
        effective
    };
    Some(Interrupt { number, cores })
}

#[cfg(test)]
mod tests;
