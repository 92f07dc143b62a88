//! Sources of a configuration and their merging.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use atas_process::configuration::{SYSTEM_FILE, SYSTEM_FOLDER, system_files};
use atas_text_file::PROBLEMS_MAX;

use super::document::{self, Entry};
use super::{Config, ConfigError, Location, Problem, keys, tasks};

/// Sources of a configuration; each load reads them again.
#[derive(Clone, Debug, Default)]
pub struct Source {
    /// Files that must exist, in order; if empty, the system's files, which are optional.
    pub files: Vec<PathBuf>,
    /// `section.key=value`, in order.
    pub flags: Vec<String>,
}

impl std::fmt::Display for Source {
    /// Prints the sources, for the log.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.files.is_empty() {
            write!(f, "{SYSTEM_FILE} and {SYSTEM_FOLDER} (if they exist)")?;
        }
        for (index, file) in self.files.iter().enumerate() {
            write!(
                f,
                "{}{}",
                if index == 0 { "" } else { ", " },
                file.display()
            )?;
        }
        match self.flags.len() {
            0 => Ok(()),
            flags => write!(f, "; {flags} on the command line"),
        }
    }
}

impl Source {
    /// Reads, merges and checks.
    ///
    /// # Errors
    /// [`ConfigError`] with all findings.
    pub fn load(&self) -> Result<Config, ConfigError> {
        let mut problems = Vec::new();
        let entries = self.entries(&mut problems);
        merge(entries, problems)
    }

    fn entries(&self, problems: &mut Vec<Problem>) -> Vec<Entry> {
        let mut leaves = Vec::new();
        let mut take = |read: Result<Vec<Entry>, Problem>| match read {
            Ok(read) => leaves.extend(read),
            Err(problem) => problems.push(problem),
        };
        for path in &self.files {
            take(read_file(path));
        }
        if self.files.is_empty() {
            match system_files() {
                Ok(files) => files.iter().for_each(|path| take(read_file(path))),
                Err(error) => take(Err(unreadable(Path::new(SYSTEM_FOLDER), &error))),
            }
        }
        for flag in &self.flags {
            take(document::read_flag(flag).map(|leaf| vec![leaf]));
        }
        leaves
    }
}

/// Merges entries, later ones win, and checks them.
fn merge(entries: Vec<Entry>, mut problems: Vec<Problem>) -> Result<Config, ConfigError> {
    let mut merged = BTreeMap::new();
    for leaf in entries {
        if problems.len() >= PROBLEMS_MAX {
            break;
        }
        check_entry(&leaf, &mut problems);
        merged.insert(leaf.key.clone(), leaf);
    }
    if !problems.is_empty() {
        return Err(ConfigError(problems));
    }
    let config = document::assemble(merged.values()).ok_or(ConfigError(problems))?;
    check_conflicts(&config, &merged)?;
    Ok(config)
}

impl Config {
    /// Reads and checks the text of one file; errors name its path.
    ///
    /// # Errors
    /// [`ConfigError`] with all findings.
    pub fn parse(path: &Path, text: &str) -> Result<Self, ConfigError> {
        match document::read_text(path, text) {
            Ok(entries) => merge(entries, Vec::new()),
            Err(problem) => Err(ConfigError(vec![problem])),
        }
    }

    /// Checks values that were changed individually.
    ///
    /// # Errors
    /// [`ConfigError`] with every value in conflict with another.
    pub fn check(&self) -> Result<(), ConfigError> {
        check_conflicts(self, &BTreeMap::new())
    }

    /// Differing keys that are fixed at run time.
    #[must_use]
    pub fn fixed_differences(&self, other: &Self) -> Vec<String> {
        self.differences(other, keys::is_fixed)
    }

    /// Differing keys that may change only while the robot is stopped.
    #[must_use]
    pub fn safety_differences(&self, other: &Self) -> Vec<String> {
        self.differences(other, |key| key.starts_with("safety."))
    }

    fn differences(&self, other: &Self, of: impl Fn(&str) -> bool) -> Vec<String> {
        let theirs: BTreeMap<_, _> = document::entries_of(other).into_iter().collect();
        let ours = document::entries_of(self).into_iter();
        ours.filter(|(key, value)| of(key) && theirs.get(key) != Some(value))
            .map(|(key, _)| key)
            .collect()
    }
}

fn read_file(path: &Path) -> Result<Vec<Entry>, Problem> {
    let text = atas_text_file::read(path).map_err(|error| unreadable(path, &error))?;
    document::read_text(path, &text)
}

fn unreadable(path: &Path, error: &io::Error) -> Problem {
    Problem::Unreadable {
        path: path.to_owned(),
        why: error.to_string(),
    }
}

/// Checks a key with defaults for the others, so that one error does not hide another.
fn check_entry(leaf: &Entry, problems: &mut Vec<Problem>) {
    let (key, place) = (leaf.key.clone(), leaf.place.clone());
    if let Some(name) = keys::task_name(&key) {
        if let Err(problem) = tasks::read(name, &leaf.value) {
            let name = name.to_owned();
            problems.push(Problem::Task {
                place,
                name,
                problem,
            });
        }
        return;
    }
    let value = leaf.value.to_string();
    if keys::is_section(&key) {
        let needs = "to be a section with keys".to_owned();
        return problems.push(Problem::InvalidValue {
            place: Some(place),
            key,
            value,
            needs,
        });
    }
    let Some(needs) = keys::permitted_values(&key) else {
        let meant = keys::suggestion(&key);
        return problems.push(Problem::UnknownKey { place, key, meant });
    };
    if !document::assemble([leaf]).is_some_and(|config| keys::is_valid(&key, &config)) {
        problems.push(Problem::InvalidValue {
            place: Some(place),
            key,
            value,
            needs,
        });
    }
}

/// Checks conflicts between keys, and the robot file.
fn check_conflicts(config: &Config, leaves: &BTreeMap<String, Entry>) -> Result<(), ConfigError> {
    let place = |key: &str| -> Option<Location> { leaves.get(key).map(|leaf| leaf.place.clone()) };
    let contradiction = |(key, value, needs): (&str, f64, String)| Problem::InvalidValue {
        place: place(key),
        key: key.to_owned(),
        value: value.to_string(),
        needs,
    };
    let mut problems: Vec<_> = keys::conflicts(config).map(contradiction).collect();
    if let Err(error) = config.robot_model() {
        problems.push(Problem::Robot {
            why: error.to_string(),
        });
    }
    if problems.is_empty() {
        Ok(())
    } else {
        Err(ConfigError(problems))
    }
}
