//! `atas record check` and `atas record repair`: whether a file is whole, and what of it can be saved.

use std::path::{Path, PathBuf};

use serde_json::json;
use shm_schemas::TickInputs;

use super::reader::{Entry, Reader, word};
use super::writer::Writer;
use crate::exit::{Ended, Exit};
use crate::output::Output;

/// What a file holds, as far as it can be read.
#[derive(Debug, Default)]
struct Contents {
    messages: u64,
    parts: u64,
    lost: u64,
    first: Option<u64>,
    next: Option<u64>,
    /// Why it cannot be read to its end.
    damage: Option<String>,
}

impl Contents {
    fn of(path: &Path, mut each: impl FnMut(&Entry) -> anyhow::Result<()>) -> anyhow::Result<Self> {
        let mut contents = Self::default();
        for entry in Reader::open(path)? {
            match entry {
                Ok(entry) => {
                    contents.count(&entry);
                    each(&entry)?;
                }
                Err(error) => contents.damage = Some(one_line(&error)),
            }
        }
        Ok(contents)
    }

    fn count(&mut self, entry: &Entry) {
        let Entry::Message(message) = entry else {
            return;
        };
        self.messages += 1;
        let Some(part) = word::<TickInputs>(message) else {
            return;
        };
        self.parts += 1;
        let sequence = part.stamp.sequence;
        self.first.get_or_insert(sequence);
        self.lost += self.next.map_or(0, |next| sequence.saturating_sub(next));
        self.next = Some(sequence.saturating_add(1));
    }

    fn print(&self, output: &mut Output) -> anyhow::Result<()> {
        if output.is_json() {
            return output.json(&json!({
                "messages": self.messages,
                "parts": self.parts,
                "lost": self.lost,
                "first_part": self.first,
                "damage": self.damage,
            }));
        }
        output.line(format_args!(
            "{} messages, {} parts of ticks, {} lost, first part {}",
            self.messages,
            self.parts,
            self.lost,
            self.first
                .map_or("none".to_owned(), |first| first.to_string()),
        ))
    }
}

/// `atas record check`.
pub(crate) fn check(path: &Path, output: &mut Output) -> anyhow::Result<()> {
    let contents = Contents::of(path, |_| Ok(()))?;
    contents.print(output)?;
    if let Some(damage) = contents.damage {
        return Err(Ended::with(Exit::Failed, damage));
    }
    if contents.lost > 0 {
        let sentence = format!("{} parts of ticks are missing in between", contents.lost);
        return Err(Ended::with(Exit::Failed, sentence));
    }
    Ok(())
}

/// `atas record repair`: saves what can be read.
pub(crate) fn repair(path: &Path, out: Option<&Path>, output: &mut Output) -> anyhow::Result<()> {
    let out = out.map_or_else(|| repaired(path), Path::to_owned);
    let contents = save(path, &out)?;
    if !output.is_json() {
        output.line(format_args!("saved into {}:", out.display()))?;
    }
    contents.print(output)
}

/// Writes what can be read into a new, whole file.
fn save(path: &Path, out: &Path) -> anyhow::Result<Contents> {
    let mut writer = Writer::create(out)?;
    let contents = Contents::of(path, |entry| match entry {
        Entry::Message(message) => writer.copy(message),
        Entry::Metadata(metadata) => writer.describe(metadata),
    })?;
    writer.finish()?;
    Ok(contents)
}

/// The parser of records draws pictures over several lines; the first says what it is about.
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
mod tests;
