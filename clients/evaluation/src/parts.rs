//! An evaluation in parts, on several machines or one after another: each part runs every so-many-th trial and keeps what came
//! of them in a file; all files together give the report of one run.
//!
//! ```text
//!  Plan ─▶ shard 1/3 ─▶ part file ─┐
//!       ─▶ shard 2/3 ─▶ part file ─┼─▶ merge ─▶ Evaluated, as of one run
//!       ─▶ shard 3/3 ─▶ part file ─┘
//! ```
//!
//! A part file is a [`Header`] and then the trials as they ended, in `MessagePack`, which keeps every bit of a number. A trial is
//! written when it has ended: a part that was interrupted or killed goes on behind the last whole one.
//!
//! * **Invariants:** parts of different plans, programs or robots are never put together; nor are parts of which one is missing,
//!   is there twice or has not ended.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{File, OpenOptions};
use std::io::{BufReader, Read, Seek as _, Write as _};
use std::path::Path;

use anyhow::{Context as _, bail, ensure};
use serde::{Deserialize, Serialize};

use crate::plan::{Plan, Shard};
use crate::trial::Record;

/// What a part file begins with.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// Of everything that decides about the trials: plan, robot, objects, version of the program.
    pub plan_hash: u64,
    /// Which part it is.
    pub shard: Shard,
    /// What the evaluation was told, for whoever puts the parts together.
    pub arguments: String,
}

/// A trial in a part file: its index in the plan, and what came of it.
type Entry = (usize, Record);

/// A part file that trials are added to.
#[derive(Debug)]
pub struct Part {
    file: File,
    ended: BTreeSet<usize>,
}

impl Part {
    /// Begins a part file, or goes on with one of the same header.
    ///
    /// # Errors
    /// The file cannot be read or written, or is part of something else.
    pub fn open(path: &Path, header: &Header) -> anyhow::Result<Self> {
        let shown = path.display();
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .with_context(|| {
                format!(
                    "could not open {shown}; name a file in a folder that exists and may be written"
                )
            })?;
        let mut ended = BTreeSet::new();
        if file.metadata()?.len() > 0 {
            let (found, entries, whole_bytes) = read(&file, path)?;
            ensure!(
                found == *header,
                "could not go on with {shown} because it is a part of another evaluation; name another file, or remove it"
            );
            ended.extend(entries.into_keys());
            file.set_len(whole_bytes)?;
            file.seek(std::io::SeekFrom::End(0))?;
        } else {
            file.write_all(&rmp_serde::to_vec(header)?)
                .with_context(|| format!("could not write {shown}"))?;
        }
        Ok(Self { file, ended })
    }

    /// Trials that it has.
    #[must_use]
    pub fn ended(&self) -> &BTreeSet<usize> {
        &self.ended
    }

    pub(crate) fn add(&mut self, index: usize, record: &Record) -> anyhow::Result<()> {
        let bytes = rmp_serde::to_vec(&(index, record))?;
        self.file.write_all(&bytes).context(
            "could not write a trial; make room, and run the same command again: it goes on",
        )
    }
}

/// The header of a part file.
///
/// # Errors
/// It cannot be read, or is no part file.
pub fn header(path: &Path) -> anyhow::Result<Header> {
    read_header(&mut open(path)?, path)
}

/// The trials of all parts of a plan, in its order.
///
/// # Errors
/// A part cannot be read, is of another plan, is missing, is there twice, or has not ended.
pub(crate) fn gather(plan: &Plan, paths: &[impl AsRef<Path>]) -> anyhow::Result<Vec<Record>> {
    let plan_hash = plan.hash();
    let mut all = BTreeMap::new();
    let mut numbers = BTreeSet::new();
    let mut of = 0;
    for path in paths.iter().map(AsRef::as_ref) {
        let shown = path.display();
        let (header, entries, _) = read(&open(path)?, path)?;
        ensure!(
            header.plan_hash == plan_hash,
            "could not merge {shown} because it is of another evaluation, or robot, objects or program have changed since; \
             run its shard again"
        );
        ensure!(
            of == 0 || of == header.shard.of,
            "could not merge {shown} because it is one of {} parts, and others are of {of}",
            header.shard.of
        );
        of = header.shard.of;
        let number = header.shard.number;
        ensure!(
            numbers.insert(number),
            "could not merge {shown} because part {number}/{of} is there twice"
        );
        let wanted = (0..plan.jobs() as usize).filter(|&index| header.shard.has(index));
        ensure!(
            entries.keys().copied().eq(wanted.clone()),
            "could not merge {shown} because it has {} of {} trials; run its command again, it goes on where it ended",
            entries.len(),
            wanted.count()
        );
        all.extend(entries);
    }
    if let Some(missing) = (1..=of).find(|number| !numbers.contains(number)) {
        bail!("could not merge because part {missing}/{of} is missing; name its file as well");
    }
    Ok(all.into_values().collect())
}

fn open(path: &Path) -> anyhow::Result<File> {
    File::open(path).with_context(|| format!("could not open {}", path.display()))
}

fn read_header(reader: &mut impl Read, path: &Path) -> anyhow::Result<Header> {
    rmp_serde::from_read(reader).with_context(|| {
        let shown = path.display();
        format!("could not read {shown} because it is no part of an evaluation")
    })
}

/// Header, trials by index, and how many bytes are whole: what a killed process left of a trial is no part of it.
fn read(file: &File, path: &Path) -> anyhow::Result<(Header, BTreeMap<usize, Record>, u64)> {
    let mut reader = BufReader::new(file);
    let header = read_header(&mut reader, path)?;
    let mut entries = BTreeMap::new();
    let mut whole_bytes = reader.stream_position()?;
    while let Ok((index, record)) = rmp_serde::from_read::<_, Entry>(&mut reader) {
        entries.insert(index, record);
        whole_bytes = reader.stream_position()?;
    }
    Ok((header, entries, whole_bytes))
}
