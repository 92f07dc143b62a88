//! The folder of an experiment: what is finished is never lost.

use std::fs::{File, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::plan::{Job, Plan};
use crate::error::{Error, Result};
use crate::files::{FolderLock, read_text, write_atomically};
use crate::run::Record;

const PLAN: &str = "experiment.toml";
const RUNS: &str = "runs.jsonl";

/// An experiment's folder, locked for this process.
#[derive(Debug)]
pub struct Store {
    _lock: FolderLock,
    path: PathBuf,
    file: File,
    /// Length of the file after the last whole line.
    length: u64,
}

impl Store {
    /// Opens the folder of this plan, new or begun, and reads the runs that are finished.
    ///
    /// # Errors
    /// Another process works on it, it holds another experiment, it is damaged, or the system refused.
    pub fn open(folder: &Path, plan: &Plan) -> Result<(Self, Vec<Record>)> {
        let lock = FolderLock::take(folder)?;
        let plan_path = folder.join(PLAN);
        if plan_path.exists() {
            same_plan(folder, plan, &read_plan(folder)?)?;
        } else {
            let text = toml::to_string(plan).map_err(Error::from_part)?;
            write_atomically(&plan_path, text.as_bytes())?;
        }
        let path = folder.join(RUNS);
        let mut file = OpenOptions::new()
            .create(true)
            .truncate(false)
            .read(true)
            .write(true)
            .open(&path)
            .map_err(Error::io("open", &path))?;
        let text = read_text(&path)?;
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let records = parse(&path, &text[..whole])?;
        // A line without an end is a run whose writing was cut off: it will be run again.
        file.set_len(whole as u64)
            .and_then(|()| file.seek(SeekFrom::End(0)))
            .map_err(Error::io("mend", &path))?;
        Ok((
            Self {
                _lock: lock,
                path,
                file,
                length: whole as u64,
            },
            records,
        ))
    }

    /// Adds a finished run; when this returns, it is on the disk.
    ///
    /// # Errors
    /// The system refused, for example because the disk is full. The runs before are safe.
    pub fn append(&mut self, record: &Record) -> Result<()> {
        let mut line = serde_json::to_string(record).map_err(Error::from_part)?;
        line.push('\n');
        let written = self
            .file
            .write_all(line.as_bytes())
            .and_then(|()| self.file.sync_data());
        if let Err(error) = written {
            // If this fails too, the next opening cuts the torn line off.
            let _ = self.file.set_len(self.length);
            return Err(Error::io("write a finished run to", &self.path)(error));
        }
        self.length += line.len() as u64;
        Ok(())
    }
}

/// The plan and the finished runs of a folder, sorted by team size and seed, without locking it.
///
/// # Errors
/// It holds no experiment, or a damaged one.
pub fn read_folder(folder: &Path) -> Result<(Plan, Vec<Record>)> {
    let plan = read_plan(folder)?;
    let path = folder.join(RUNS);
    let text = read_text(&path)?;
    let whole = text.rfind('\n').map_or(0, |end| end + 1);
    let mut records = parse(&path, &text[..whole])?;
    records.sort_by_key(|record| Job {
        agents: record.agents,
        seed: record.seed,
    });
    Ok((plan, records))
}

fn read_plan(folder: &Path) -> Result<Plan> {
    let path = folder.join(PLAN);
    toml::from_str(&read_text(&path)?).map_err(|error| {
        Error::refused(
            format_args!("use experiment {}", path.display()),
            error.message(),
            "a plan as ebts experiment writes it",
            "name another folder, or remove this one",
        )
    })
}

/// Refuses a folder that holds another experiment, naming what differs.
pub(super) fn same_plan(folder: &Path, wanted: &Plan, found: &Plan) -> Result<()> {
    if wanted == found {
        return Ok(());
    }
    let fields = |plan: &Plan| toml::Table::try_from(plan).unwrap_or_default();
    let (wanted, found) = (fields(wanted), fields(found));
    let differs = wanted
        .iter()
        .find(|(key, value)| found.get(*key) != Some(value));
    let (key, value) = differs.map_or(("plan", String::new()), |(key, value)| {
        (key.as_str(), value.to_string())
    });
    let there = found.get(key).map(ToString::to_string).unwrap_or_default();
    Err(Error::refused(
        format_args!("add to experiment {}", folder.display()),
        format_args!("its {key} was {there}"),
        format_args!("{value}"),
        "name another --out",
    ))
}

fn parse(path: &Path, text: &str) -> Result<Vec<Record>> {
    let line = |(number, line): (usize, &str)| {
        serde_json::from_str(line).map_err(|error| {
            Error::refused(
                format_args!("read {}", path.display()),
                format_args!("line {} was damaged ({error})", number + 1),
                "one finished run per line",
                "remove that line and run the experiment again: only that run is repeated",
            )
        })
    };
    text.lines().enumerate().map(line).collect()
}
