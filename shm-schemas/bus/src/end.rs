//! Record of the ends of a bus's owners: why the last one ended.
//!
//! ```text
//!  start ─▶ process and role, end of the former owner      end ─▶ cause, appended
//! ```
//!
//! A process that is killed appends nothing. The record outlives the processes of the bus.

use std::fmt;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::PathBuf;

use crate::folder::Folder;
use crate::lock::FileLock;
use crate::name::BusName;
use crate::owner::Owner;

/// File of the record in the bus's folder.
pub(crate) const END_RECORD: &str = "owner.end";
/// Cause of an orderly end.
const ORDERLY: &str = "ended";
/// Longest recorded cause, characters. Design choice: several sentences.
const CAUSE_MAX: usize = 500;

/// Unexpected end of a process that owned a bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct End {
    /// The process.
    pub owner: Owner,
    /// What it recorded; `None` if it was killed or could not write.
    pub cause: Option<String>,
}

impl End {
    /// The unexpected end of the last owner of a bus; `None` if the bus has an owner, or if that
    /// cannot be determined.
    #[must_use]
    pub fn last(bus: &BusName) -> Option<Self> {
        if Owner::find(bus).is_some() || !FileLock::shows_holders() {
            return None;
        }
        // Read afterwards: an owner records its end before it releases the lock.
        Record::read(&Folder::for_bus(bus).ok()?).end()
    }

    /// The unexpected end of the owner before this one.
    #[must_use]
    pub fn before(bus: &BusName, owner_pid: u32) -> Option<Self> {
        let record = Record::read(&Folder::for_bus(bus).ok()?);
        let is_of_owner = record.owner.is_some_and(|end| end.owner.pid == owner_pid);
        record.former.filter(|_| is_of_owner)
    }

    fn parse(line: &str) -> Option<Self> {
        let mut parts = line.splitn(3, '\t');
        let owner = Owner {
            pid: parts.next()?.parse().ok()?,
            role: parts.next()?.to_owned(),
        };
        let cause = parts.next().filter(|cause| !cause.is_empty());
        Some(Self {
            owner,
            cause: cause.map(str::to_owned),
        })
    }
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.cause {
            Some(cause) => write!(f, "{} {cause}", self.owner),
            None => write!(
                f,
                "{} ended without a recorded cause: it was killed, or the machine stopped",
                self.owner
            ),
        }
    }
}

/// Content of the record.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Record {
    owner: Option<End>,
    former: Option<End>,
}

impl Record {
    fn read(folder: &Folder) -> Self {
        let bytes = fs::read(folder.path.join(END_RECORD)).unwrap_or_default();
        Self::parse(&String::from_utf8_lossy(&bytes))
    }

    fn parse(text: &str) -> Self {
        let mut lines = text.lines();
        let owner = lines.next().and_then(End::parse);
        let former = lines.next().and_then(End::parse);
        let cause = lines.next().map(str::to_owned);
        Self {
            owner: owner.map(|end| End { cause, ..end }),
            former,
        }
    }

    /// Returns the end of its owner unless it was orderly.
    fn end(self) -> Option<End> {
        let orderly = |end: &End| end.cause.as_deref() == Some(ORDERLY);
        self.owner.filter(|end| !orderly(end))
    }
}

/// Record of the present owner, open for its end.
#[derive(Debug)]
pub(crate) struct EndRecord {
    file: File,
    path: PathBuf,
    former: Option<End>,
}

impl EndRecord {
    /// Begins the record of this process. Call under the owner lock.
    pub(crate) fn begin(folder: &Folder, role: &str) -> io::Result<Self> {
        let former = Record::read(folder).end();
        let path = folder.path.join(END_RECORD);
        // Complete at once, so that no end is lost.
        let new = path.with_extension("new");
        match fs::remove_file(&new) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let mut options = OpenOptions::new();
        let mut file = options
            .append(true)
            .create_new(true)
            .mode(0o600)
            .open(&new)?;
        let before = former.as_ref().map_or(String::new(), |end| {
            let cause = end.cause.as_deref().unwrap_or_default();
            format!("{}\t{}\t{cause}", end.owner.pid, end.owner.role)
        });
        file.write_all(format!("{}\t{role}\n{before}\n", std::process::id()).as_bytes())?;
        fs::rename(&new, &path)?;
        Ok(Self { file, path, former })
    }

    pub(crate) fn former(&self) -> Option<&End> {
        self.former.as_ref()
    }

    pub(crate) fn file(&self) -> &File {
        &self.file
    }

    /// Appends a cause, in one line. Only the first one counts.
    pub(crate) fn append(&self, cause: &str) {
        let line: String = cause.chars().take(CAUSE_MAX).collect();
        let line = line.replace(['\n', '\t'], " ") + "\n";
        if let Err(error) = (&self.file).write_all(line.as_bytes()) {
            tracing::warn!(file = %self.path.display(), %error, "could not record the end");
        }
    }
}

impl Drop for EndRecord {
    fn drop(&mut self) {
        let panics = std::thread::panicking();
        self.append(if panics { "ended by a panic" } else { ORDERLY });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn end_is_parsed_unless_orderly() {
        let check = |text: &str, end: Option<&str>, former: Option<&str>| {
            let record = Record::parse(text);
            let shown = |end: &Option<End>| end.as_ref().map(End::to_string);
            assert_eq!(shown(&record.former).as_deref(), former, "{text:?}");
            assert_eq!(shown(&record.end()).as_deref(), end, "{text:?}");
        };
        let killed = "atasd (process 7) ended without a recorded cause: it was killed, or the machine stopped";
        check("", None, None);
        check("7\tatasd\n\n", Some(killed), None);
        check("7\tatasd\n\nended\n", None, None);
        check(
            "7\tatasd\n\nended by X\nended\n",
            Some("atasd (process 7) ended by X"),
            None,
        );
        check("8\tatasd\n7\tatasd\t\nended\n", None, Some(killed));
        check(
            "8\tatasd\n7\tatasd\tended by X\n",
            Some(
                "atasd (process 8) ended without a recorded cause: it was killed, or the machine stopped",
            ),
            Some("atasd (process 7) ended by X"),
        );
        check("junk", None, None);
        check("x\ty\nz", None, None);
    }
}
