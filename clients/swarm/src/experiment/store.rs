//! Folder of an experiment. Finished runs are never lost.

use std::collections::HashSet;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::plan::Plan;
use super::seal::Seal;
use super::verify::verify;
use crate::error::{Error, Result};
use crate::files::{FolderLock, read_text, write_atomically};
use crate::run::{Job, Record};

const PLAN: &str = "experiment.toml";
const RUNS: &str = "runs.jsonl";
/// Folder with the checkpoints of unfinished runs.
const CHECKPOINTS: &str = "under-way";

/// Folder of an experiment, locked for this process.
#[derive(Debug)]
pub struct Store {
    _lock: FolderLock,
    seal: Seal,
    folder: PathBuf,
    path: PathBuf,
    file: File,
    /// Length of the file up to the last complete line.
    length: u64,
}

impl Store {
    /// Opens a new or existing folder of this plan and reads its finished runs.
    ///
    /// # Errors
    /// Another process uses the folder, it holds another experiment, it is damaged, or it cannot be
    /// read or written.
    pub fn open(folder: &Path, plan: &Plan) -> Result<(Self, Vec<Record>)> {
        let lock = FolderLock::take(folder)?;
        let plan_path = folder.join(PLAN);
        if plan_path.exists() {
            check_same_plan(folder, plan, &read_plan(folder)?)?;
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
        let seal = Seal::new(plan)?;
        let (records, length) = read_runs(&path, plan, &seal)?;
        // An incomplete line is a run whose write was interrupted; the run is repeated.
        file.set_len(length)
            .and_then(|()| file.seek(SeekFrom::End(0)))
            .map_err(Error::io("truncate", &path))?;
        let store = Self {
            _lock: lock,
            seal,
            folder: folder.to_owned(),
            path,
            file,
            length,
        };
        Ok((store, records))
    }

    /// Appends a finished run and syncs it to disk.
    ///
    /// # Errors
    /// The file cannot be written, for example because the disk is full. Earlier runs are safe.
    pub fn append(&mut self, record: &Record) -> Result<()> {
        self.write(record)?;
        self.sync()
    }

    /// Appends a finished run without sync; [`Store::sync`] writes it to disk.
    pub fn write(&mut self, record: &Record) -> Result<()> {
        let line = self.seal.line(record)?;
        if let Err(error) = self.file.write_all(line.as_bytes()) {
            // If this fails too, the next opening removes the incomplete line.
            let _ = self.file.set_len(self.length);
            return Err(Error::io("write a finished run to", &self.path)(error));
        }
        self.length += line.len() as u64;
        Ok(())
    }

    /// Waits until all written runs are on disk.
    pub fn sync(&mut self) -> Result<()> {
        let synced = self.file.sync_data();
        synced.map_err(Error::io("write finished runs to", &self.path))
    }

    /// Returns the checkpoint path of a run.
    #[must_use]
    pub fn checkpoint(&self, Job { agents, seed }: Job) -> PathBuf {
        let name = format!("{agents}-{seed}.checkpoint");
        self.folder.join(CHECKPOINTS).join(name)
    }

    /// Creates the folder of checkpoints.
    pub fn prepare_checkpoints(&self) -> Result<()> {
        let folder = self.folder.join(CHECKPOINTS);
        std::fs::create_dir_all(&folder).map_err(Error::io("create folder", &folder))
    }

    /// Removes the folder of checkpoints if it is empty.
    pub fn clear_checkpoints(&self) {
        // A folder that is not empty or does not exist is left unchanged.
        let _ = std::fs::remove_dir(self.folder.join(CHECKPOINTS));
    }
}

/// Reads the plan and the finished runs of a folder, sorted by team size and seed, without locking
/// it.
///
/// # Errors
/// The folder holds no experiment or a damaged one.
pub fn read_folder(folder: &Path) -> Result<(Plan, Vec<Record>)> {
    let plan = read_plan(folder)?;
    let path = folder.join(RUNS);
    let (mut records, _) = read_runs(&path, &plan, &Seal::new(&plan)?)?;
    records.sort_by_key(Record::job);
    Ok((plan, records))
}

fn read_plan(folder: &Path) -> Result<Plan> {
    let path = folder.join(PLAN);
    toml::from_str(&read_text(&path)?).map_err(|error| {
        Error::refused(
            format_args!("use experiment {}", path.display()),
            error.message(),
            "a plan written by ebts experiment",
            "choose another folder, or remove this one",
        )
    })
}

/// Rejects another experiment; the error names the first difference.
pub(super) fn check_same_plan(folder: &Path, wanted: &Plan, found: &Plan) -> Result<()> {
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
        format_args!("its {key} is {there}"),
        format_args!("{value}"),
        "choose another --out",
    ))
}

/// Returns the verified runs and the offset after the last complete line.
fn read_runs(path: &Path, plan: &Plan, seal: &Seal) -> Result<(Vec<Record>, u64)> {
    let damaged = |index: usize, why: &str| {
        Error::refused(
            format_args!("read {}", path.display()),
            format_args!("line {} is damaged ({why})", index + 1),
            "one finished run of this experiment per line, as written by ebts",
            "remove that line and run the experiment again: only that run is repeated",
        )
    };
    let file = File::open(path).map_err(Error::io("read", path))?;
    let (mut file, mut line) = (BufReader::new(file), String::new());
    let (mut records, mut jobs, mut length) = (Vec::new(), HashSet::new(), 0);
    while file.read_line(&mut line).map_err(Error::io("read", path))? > 0 && line.ends_with('\n') {
        let record = seal
            .open(line.trim_end())
            .map_err(|why| damaged(records.len(), &why))?;
        if !jobs.insert(record.job()) {
            return Err(damaged(records.len(), "it repeats an earlier run"));
        }
        records.push(record);
        length += line.len() as u64;
        line.clear();
    }
    match verify(plan, &records)? {
        Ok(()) => Ok((records, length)),
        Err((index, why)) => Err(damaged(index, &why)),
    }
}
