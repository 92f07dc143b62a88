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
//!   is there twice or has not ended. A trial whose seal does not fit is not believed, nor is what follows it; nothing is thrown
//!   away for it: the file as it was is kept beside.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{File, OpenOptions};
use std::io::{BufReader, Read, Seek as _, Write as _};
use std::path::Path;

use anyhow::{Context as _, bail, ensure};
use serde::{Deserialize, Serialize};
use shm_schemas::layout::{FNV_OFFSET, fnv1a};

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

/// A trial in a part file: its index in the plan, what came of it, and the seal of both.
type Entry = (usize, Record, u64);

/// FNV-1a 64 of a trial as it is written.
fn seal(index: usize, record: &Record) -> anyhow::Result<u64> {
    Ok(fnv1a(FNV_OFFSET, &rmp_serde::to_vec(&(index, record))?))
}

/// A part file that trials are added to.
#[derive(Debug)]
pub struct Part {
    file: File,
    ended: BTreeSet<usize>,
    warning: Option<String>,
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
        let (mut ended, mut warning) = (BTreeSet::new(), None);
        if file.metadata()?.len() > 0 {
            let found = read(&file, path)?;
            ensure!(
                found.header == *header,
                "could not go on with {shown} because it is a part of another evaluation; name another file, or remove it"
            );
            if let Some(why) = found.damage {
                let kept = format!("{shown}.damaged");
                std::fs::copy(path, &kept).with_context(|| format!("could not write {kept}"))?;
                let trials = found.entries.len();
                warning = Some(format!(
                    "{shown} was damaged behind its trial {trials} ({why}): it goes on from there; as it was it is kept as {kept}"
                ));
            }
            ended.extend(found.entries.into_keys());
            file.set_len(found.whole_bytes)?;
            file.seek(std::io::SeekFrom::End(0))?;
        } else {
            file.write_all(&rmp_serde::to_vec(header)?)
                .with_context(|| format!("could not write {shown}"))?;
        }
        Ok(Self {
            file,
            ended,
            warning,
        })
    }

    /// What was wrong with the file when it was opened, and where it is kept as it was.
    #[must_use]
    pub fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// Trials that it has.
    #[must_use]
    pub fn ended(&self) -> &BTreeSet<usize> {
        &self.ended
    }

    pub(crate) fn add(&mut self, index: usize, record: &Record) -> anyhow::Result<()> {
        let bytes = rmp_serde::to_vec(&(index, record, seal(index, record)?))?;
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
        let Contents {
            header,
            entries,
            damage,
            ..
        } = read(&open(path)?, path)?;
        if let Some(why) = damage {
            bail!(
                "could not merge {shown} because it was damaged behind its trial {} ({why}); run its command again, it goes on \
                 from there",
                entries.len()
            );
        }
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

/// What a part file holds.
struct Contents {
    header: Header,
    /// Trials by index.
    entries: BTreeMap<usize, Record>,
    /// Header and whole trials.
    whole_bytes: u64,
    /// What is wrong with what follows, such as what a killed process left of a trial.
    damage: Option<String>,
}

fn read(file: &File, path: &Path) -> anyhow::Result<Contents> {
    let all_bytes = file.metadata()?.len();
    let mut reader = BufReader::new(file);
    let mut contents = Contents {
        header: read_header(&mut reader, path)?,
        entries: BTreeMap::new(),
        whole_bytes: reader.stream_position()?,
        damage: None,
    };
    while contents.damage.is_none() && contents.whole_bytes < all_bytes {
        match rmp_serde::from_read::<_, Entry>(&mut reader) {
            Ok((index, record, sealed)) if seal(index, &record)? == sealed => {
                contents.entries.insert(index, record);
                contents.whole_bytes = reader.stream_position()?;
            }
            Ok(_) => contents.damage = Some("its seal does not fit".to_owned()),
            Err(error) => contents.damage = Some(error.to_string()),
        }
    }
    Ok(contents)
}
