//! Safe fixes of `atas doctor --fix`.
//!
//! ```text
//!  files of dead processes ─▶ lock and wipe each bus ─▶ remove its old unmapped files
//!  governors ──────────────▶ write `performance`, or print the command
//! ```
//!
//! * **Invariants:** files of living processes and of other users are never changed. A dry run
//!   changes nothing.

use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::process::geteuid;
use serde_json::{Value, json};
use shm_bus::{Bus, BusName};

use super::checks;
use super::root::Root;
use super::stale::{Doubt, Remains, Stale};

/// Least age of a file without a bus folder before it is removed. Design choice: a process maps a
/// new file within milliseconds. If it is too small, a file under creation is removed.
const AGE_MIN: Duration = Duration::from_secs(10);
const PERFORMANCE: &str = "performance";
/// Command that sets the governor of all cores.
const SET_GOVERNOR: &str =
    "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor";

/// Result of a fix.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// A dry run would do it.
    Planned,
    /// Done.
    Done,
    /// Not done.
    Refused {
        /// Cause.
        reason: String,
        /// Command for the user; empty if there is none.
        command: String,
    },
}

/// One fix of a finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Fix {
    /// Probe of the finding.
    pub(super) probe: &'static str,
    /// Description, as an imperative.
    pub(super) action: String,
    pub(super) outcome: Outcome,
}

impl Fix {
    pub(super) fn text(&self) -> String {
        let action = &self.action;
        match &self.outcome {
            Outcome::Planned => format!("planned: {action}"),
            Outcome::Done => format!("done: {action}"),
            Outcome::Refused { reason, command } if command.is_empty() => {
                format!("refused: {action}: {reason}")
            }
            Outcome::Refused { reason, command } => {
                format!("refused: {action}: {reason}; run `{command}`")
            }
        }
    }

    pub(super) fn as_json(&self) -> Value {
        let (result, reason, command) = match &self.outcome {
            Outcome::Planned => ("planned", "", ""),
            Outcome::Done => ("done", "", ""),
            Outcome::Refused { reason, command } => ("refused", reason.as_str(), command.as_str()),
        };
        json!({"action": self.action, "result": result, "reason": reason, "command": command})
    }
}

/// Runs all safe fixes, or plans them in a dry run.
pub(super) fn run(root: &Root, dry_run: bool) -> Vec<Fix> {
    let mut fixes = remove_stale(root, dry_run);
    fixes.extend(set_governor(root, dry_run));
    fixes
}

/// Removes the remains of this user's killed processes.
fn remove_stale(root: &Root, dry_run: bool) -> Vec<Fix> {
    let stale = Stale::find(root, geteuid().as_raw());
    let left = stale.buses.iter();
    let left = left.filter(|(_, remains)| checks::is_leftover(remains.bytes));
    left.map(|(bus, remains)| Fix {
        probe: checks::LEFTOVERS,
        action: format!(
            "remove {} files of bus {bus}, {} bytes",
            remains.files.len(),
            remains.bytes
        ),
        outcome: remove_bus(root, bus, &stale, remains, dry_run),
    })
    .collect()
}

fn remove_bus(root: &Root, bus: &str, stale: &Stale, remains: &Remains, dry_run: bool) -> Outcome {
    let Ok(name) = bus.parse::<BusName>() else {
        return refused("this is not the name of a bus", "");
    };
    if let Some(doubt) = stale.doubt
        && (doubt == Doubt::Container || Bus::find(&name).is_err())
    {
        // No lock shows the processes of this bus.
        return unseen(&name, doubt);
    }
    if dry_run {
        return Outcome::Planned;
    }
    // The locks of the bus exclude every process that is on it or joins it.
    match Bus::wipe(&name) {
        Ok(_) => remove_files(root, &name, &remains.files),
        Err(error) => refused(error.to_string(), ""),
    }
}

/// Removes files of former lives of a bus and of a bus without folder, for example after a log-out.
fn remove_files(root: &Root, bus: &BusName, planned: &[PathBuf]) -> Outcome {
    let left: Vec<&PathBuf> = planned.iter().filter(|file| file.exists()).collect();
    if left.is_empty() {
        return Outcome::Done;
    }
    let stale = Stale::find(root, geteuid().as_raw());
    if let Some(doubt) = stale.doubt {
        return unseen(bus, doubt);
    }
    let unused = stale.buses.get(bus.as_str());
    let unused = unused.map_or(&[][..], |remains| &remains.files);
    for file in left {
        if !unused.contains(file) {
            return refused("a process uses the bus now", "");
        }
        if !is_old(file) {
            let reason = format!("a file is younger than {} s", AGE_MIN.as_secs());
            return refused(reason, "atas doctor --fix");
        }
        if let Err(error) = fs::remove_file(file) {
            return refused(format!("could not remove {}: {error}", file.display()), "");
        }
    }
    Outcome::Done
}

/// Refuses to remove files that an invisible process may use.
fn unseen(bus: &BusName, doubt: Doubt) -> Outcome {
    refused(
        format!("{}; if no process uses the bus", doubt.reason()),
        format!("rm /dev/shm/{bus}_*"),
    )
}

fn is_old(file: &Path) -> bool {
    let changed = fs::symlink_metadata(file).and_then(|meta| meta.modified());
    let age = changed.ok().and_then(|changed| changed.elapsed().ok());
    age.is_some_and(|age| age >= AGE_MIN)
}

/// Sets the frequency governor of all cores to `performance`.
fn set_governor(root: &Root, dry_run: bool) -> Option<Fix> {
    let mut files = root.frequency_files("scaling_governor");
    files.retain(|file| {
        fs::read_to_string(file).is_ok_and(|governor| governor.trim() != PERFORMANCE)
    });
    if files.is_empty() {
        return None;
    }
    Some(Fix {
        probe: checks::GOVERNOR,
        action: format!("set the governor of {} cores to {PERFORMANCE}", files.len()),
        outcome: write_governors(&files, dry_run),
    })
}

fn write_governors(files: &[PathBuf], dry_run: bool) -> Outcome {
    for file in files {
        if let Err(error) = write_governor(file, dry_run) {
            return refused(error.to_string(), SET_GOVERNOR);
        }
    }
    if dry_run {
        Outcome::Planned
    } else {
        Outcome::Done
    }
}

/// Writes the governor of one core. A dry run only checks the permission.
fn write_governor(file: &Path, dry_run: bool) -> io::Result<()> {
    let mut opened = OpenOptions::new().write(true).open(file)?;
    if dry_run {
        return Ok(());
    }
    opened.write_all(PERFORMANCE.as_bytes())
}

fn refused(reason: impl Into<String>, command: impl Into<String>) -> Outcome {
    Outcome::Refused {
        reason: reason.into(),
        command: command.into(),
    }
}

#[cfg(test)]
mod tests;
