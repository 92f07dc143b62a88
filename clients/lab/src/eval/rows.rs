//! Trial results as a file with one row per trial.

use std::fs;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use atas_console::{Exit, ExitError};
use atas_evaluation::TrialRow;
use atas_process::file_name::suffix;

/// File of rows, created before the trials begin so that a wrong path fails early.
pub(super) struct File {
    path: PathBuf,
    kind: Kind,
    file: fs::File,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Comma-separated values with a header line; missing values are empty.
    Csv,
    /// One JSON object per line; missing values are null.
    Jsonl,
}

impl File {
    pub(super) fn create(path: &Path) -> anyhow::Result<Self> {
        let kind = match suffix(path).as_str() {
            "csv" => Kind::Csv,
            "jsonl" => Kind::Jsonl,
            _ => {
                let sentence = format!(
                    "could not write rows to {}: unknown suffix, needs .csv or .jsonl; rename the \
                     file",
                    path.display()
                );
                return Err(ExitError::with_code(Exit::Usage, sentence));
            }
        };
        let file = fs::File::create(path).with_context(|| write_error(path))?;
        Ok(Self {
            path: path.to_owned(),
            kind,
            file,
        })
    }

    pub(super) fn write<'a>(self, rows: impl Iterator<Item = &'a TrialRow>) -> anyhow::Result<()> {
        let written = match self.kind {
            Kind::Csv => csv(self.file, rows),
            Kind::Jsonl => jsonl(self.file, rows),
        };
        written.with_context(|| write_error(&self.path))
    }
}

fn write_error(path: &Path) -> String {
    format!(
        "could not write {}; name a file in a writable folder",
        path.display()
    )
}

fn csv<'a>(file: fs::File, rows: impl Iterator<Item = &'a TrialRow>) -> anyhow::Result<()> {
    let mut writer = csv::Writer::from_writer(file);
    for row in rows {
        writer.serialize(row)?;
    }
    Ok(writer.flush()?)
}

fn jsonl<'a>(file: fs::File, rows: impl Iterator<Item = &'a TrialRow>) -> anyhow::Result<()> {
    let mut writer = BufWriter::new(file);
    for row in rows {
        serde_json::to_writer(&mut writer, row)?;
        writeln!(writer)?;
    }
    Ok(writer.flush()?)
}
