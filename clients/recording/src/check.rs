//! Check and repair of recordings.

// Numbers of a file or a device reach this arithmetic.
#![warn(clippy::arithmetic_side_effects)]

use std::path::{Path, PathBuf};

use shm_schemas::{Payload, TickInputs};

use super::reader::{Entry, Reader, payload};
use super::writer::Writer;

/// Readable contents of a file.
#[derive(Debug, Default)]
pub struct Contents {
    /// Messages of any kind.
    pub messages: u64,
    /// Parts of ticks.
    pub parts: u64,
    /// Missing parts.
    pub lost: u64,
    /// Sequence of the first part.
    pub first: Option<u64>,
    next: Option<u64>,
    /// Reason why the file is not readable to its end.
    pub damage: Option<String>,
}

impl Contents {
    fn read(
        path: &Path,
        mut each: impl FnMut(&Entry) -> anyhow::Result<()>,
    ) -> anyhow::Result<Self> {
        let mut contents = Self::default();
        for entry in Reader::open(path)? {
            match entry {
                Ok(entry) => match contents.count(&entry) {
                    // The version matches but the part is invalid: the file was changed.
                    Err(error) if has_part_type(&entry) => {
                        contents.damage = Some(one_line(&error));
                    }
                    counted => {
                        counted?;
                        each(&entry)?;
                    }
                },
                Err(error) => contents.damage = Some(one_line(&error)),
            }
        }
        Ok(contents)
    }

    fn count(&mut self, entry: &Entry) -> anyhow::Result<()> {
        let Entry::Message(message) = entry else {
            return Ok(());
        };
        let part = payload::<TickInputs>(message)?;
        self.messages = self.messages.saturating_add(1);
        let Some(part) = part else {
            return Ok(());
        };
        self.parts = self.parts.saturating_add(1);
        let sequence = part.stamp.sequence;
        self.first.get_or_insert(sequence);
        let gap = self.next.map_or(0, |next| sequence.saturating_sub(next));
        self.lost = self.lost.saturating_add(gap);
        self.next = Some(sequence.saturating_add(1));
        Ok(())
    }
}

fn has_part_type(entry: &Entry) -> bool {
    let Entry::Message(message) = entry else {
        return false;
    };
    let schema = message.channel.schema.as_ref();
    schema.is_some_and(|schema| schema.name == TickInputs::TYPE_NAME)
}

/// Reads a file and returns its contents, with the damage if it is not readable to its end.
///
/// # Errors
/// The file cannot be opened.
pub fn check(path: &Path) -> anyhow::Result<Contents> {
    Contents::read(path, |_| Ok(()))
}

/// Saves the readable part of a recording into `out`, or into a file with a similar name. Returns
/// the path and the saved contents.
///
/// # Errors
/// The file cannot be opened, or the new file cannot be created.
pub fn repair(path: &Path, out: Option<&Path>) -> anyhow::Result<(PathBuf, Contents)> {
    let out = out.map_or_else(|| repaired(path), Path::to_owned);
    let contents = save(path, &out)?;
    Ok((out, contents))
}

/// Writes all readable entries into a new, complete file.
fn save(path: &Path, out: &Path) -> anyhow::Result<Contents> {
    let mut writer = Writer::create(out)?;
    let contents = Contents::read(path, |entry| match entry {
        Entry::Message(message) => writer.copy(message),
        Entry::Metadata(metadata) => writer.describe(metadata),
    })?;
    writer.finish()?;
    Ok(contents)
}

/// Returns the first line of an error. The record parser adds drawings on further lines.
fn one_line(error: &anyhow::Error) -> String {
    let text = format!("{error:#}");
    let line = text.lines().next().unwrap_or_default();
    line.trim_end_matches([' ', ':']).to_owned()
}

fn repaired(path: &Path) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-repaired.mcap"))
}

#[cfg(test)]
#[allow(clippy::arithmetic_side_effects, reason = "numbers of the tests only")]
mod tests;
