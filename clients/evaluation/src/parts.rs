//! Evaluation in parts, for several machines: part i of N runs every N-th trial into a file;
//! merged, the files give the report of one run.
//!
//! ```text
//!  Plan ─▶ shard 1/3 ─▶ part file ─┐
//!       ─▶ shard 2/3 ─▶ part file ─┼─▶ merge ─▶ Evaluated, as of one run
//!       ─▶ shard 3/3 ─▶ part file ─┘
//! ```
//!
//! A part file is a [`Header`] followed by the finished trials in `MessagePack`, which keeps every
//! bit of a number. An interrupted part resumes after its last complete trial.
//!
//! * **Invariants:** merging rejects parts of different plans, programs or robots, and missing,
//!   duplicate or incomplete parts. Reading stops at the first trial with a wrong checksum; the
//!   damaged file is copied to `FILE.damaged`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{File, OpenOptions};
use std::io::{BufReader, Read, Seek as _, Write as _};
use std::path::Path;

use anyhow::{Context as _, bail, ensure};
use serde::{Deserialize, Serialize};
use shm_schemas::layout::{FNV_OFFSET, fnv1a};

use crate::plan::{Plan, Shard};
use crate::trial::Record;

/// Header of a part file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// Hash of plan, robot, objects and program version.
    pub plan_hash: u64,
    /// The shard.
    pub shard: Shard,
    /// Command-line arguments, for `merge`.
    pub arguments: String,
}

/// Trial: index in the plan, record, checksum of both.
type Entry = (usize, Record, u64);

fn checksum(index: usize, record: &Record) -> anyhow::Result<u64> {
    Ok(fnv1a(FNV_OFFSET, &rmp_serde::to_vec(&(index, record))?))
}

/// Part file opened for appending trials.
#[derive(Debug)]
pub struct Part {
    file: File,
    ended: BTreeSet<usize>,
    warning: Option<String>,
}

impl Part {
    /// Creates a part file, or resumes one with the same header.
    ///
    /// # Errors
    /// The file cannot be read or written, or has another header.
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
                "could not resume {shown}: it is a part of another evaluation; name another file, \
                 or remove it"
            );
            if let Some(why) = found.damage {
                let kept = format!("{shown}.damaged");
                std::fs::copy(path, &kept).with_context(|| format!("could not write {kept}"))?;
                let trials = found.entries.len();
                warning = Some(format!(
                    "{shown} is damaged after its trial {trials} ({why}): it resumes from there; a \
                     copy of the damaged file is {kept}"
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

    /// Describes damage found when the file was opened, with the path of the copy.
    #[must_use]
    pub fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// Returns the indices of the finished trials.
    #[must_use]
    pub fn ended(&self) -> &BTreeSet<usize> {
        &self.ended
    }

    pub(crate) fn add(&mut self, index: usize, record: &Record) -> anyhow::Result<()> {
        let bytes = rmp_serde::to_vec(&(index, record, checksum(index, record)?))?;
        self.file.write_all(&bytes).context(
            "could not write a trial; free disk space and run the same command again to resume",
        )
    }
}

/// Reads the header of a part file.
///
/// # Errors
/// The file cannot be read, or is not a part file.
pub fn header(path: &Path) -> anyhow::Result<Header> {
    read_header(&mut open(path)?, path)
}

/// Reads the trials of all parts, in the plan's order.
///
/// # Errors
/// A part is unreadable, foreign, missing, duplicate or incomplete.
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
                "could not merge {shown}: it is damaged after its trial {} ({why}); run its \
                 command again to resume from there",
                entries.len()
            );
        }
        ensure!(
            header.plan_hash == plan_hash,
            "could not merge {shown}: it belongs to another evaluation, or robot, objects or \
             program have changed since; run its shard again"
        );
        ensure!(
            of == 0 || of == header.shard.of,
            "could not merge {shown}: it is one of {} parts, but other files are parts of {of}",
            header.shard.of
        );
        of = header.shard.of;
        let number = header.shard.number;
        ensure!(
            numbers.insert(number),
            "could not merge {shown}: part {number}/{of} is given twice"
        );
        let wanted = (0..plan.jobs() as usize).filter(|&index| header.shard.contains(index));
        ensure!(
            entries.keys().copied().eq(wanted.clone()),
            "could not merge {shown}: it has {} of {} trials; run its command again to resume",
            entries.len(),
            wanted.count()
        );
        all.extend(entries);
    }
    if let Some(missing) = (1..=of).find(|number| !numbers.contains(number)) {
        bail!("could not merge: part {missing}/{of} is missing; add its file");
    }
    Ok(all.into_values().collect())
}

fn open(path: &Path) -> anyhow::Result<File> {
    File::open(path).with_context(|| format!("could not open {}", path.display()))
}

fn read_header(reader: &mut impl Read, path: &Path) -> anyhow::Result<Header> {
    rmp_serde::from_read(reader).with_context(|| {
        let shown = path.display();
        format!("could not read {shown}: it is not a part file of an evaluation")
    })
}

struct Contents {
    header: Header,
    entries: BTreeMap<usize, Record>,
    /// Size of header and complete trials.
    whole_bytes: u64,
    /// Damage after the complete trials, such as a partial trial of a killed process.
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
            Ok((index, record, sealed)) if checksum(index, &record)? == sealed => {
                contents.entries.insert(index, record);
                contents.whole_bytes = reader.stream_position()?;
            }
            Ok(_) => contents.damage = Some("its checksum is wrong".to_owned()),
            Err(error) => contents.damage = Some(error.to_string()),
        }
    }
    Ok(contents)
}
