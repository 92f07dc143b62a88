//! A table of comma-separated values, held whole. Columns may be missing, cells empty, and numbers no numbers.

use std::io::Read;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};

/// Most rows that are read (ours: a day at 100 Hz), so that a wrong file does not take all memory.
const ROWS_MAX: usize = 10_000_000;

/// A table with a header.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// Where it came from, for messages.
    pub path: PathBuf,
    header: Vec<String>,
    rows: Vec<csv::StringRecord>,
}

impl Sheet {
    /// Reads a file.
    ///
    /// # Errors
    /// It cannot be opened, has no header or no rows, or is no table.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let file = std::fs::File::open(path)
            .with_context(|| format!("could not open {}", path.display()))?;
        Self::read(path, std::io::BufReader::new(file))
    }

    /// Reads a table from anywhere; `path` is what messages call it.
    ///
    /// # Errors
    /// As for [`Sheet::open`].
    pub fn read(path: &Path, source: impl Read) -> anyhow::Result<Self> {
        let name = path.display();
        // Rows of another length are as good as rows with missing cells.
        let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(source);
        let header = reader
            .headers()
            .with_context(|| format!("could not read {name} as a table"))?;
        let header: Vec<String> = header.iter().map(|cell| cell.trim().to_owned()).collect();
        let mut rows = Vec::new();
        for row in reader.records() {
            rows.push(row.with_context(|| {
                format!(
                    "could not read {name} beyond row {}; is it comma-separated text?",
                    rows.len() + 1
                )
            })?);
            ensure!(
                rows.len() <= ROWS_MAX,
                "could not read {name} because it has more than {ROWS_MAX} rows; split it"
            );
        }
        ensure!(
            !rows.is_empty(),
            "could not judge {name} because it has no rows, needs one per frame under a line of column names"
        );
        Ok(Self {
            path: path.to_owned(),
            header,
            rows,
        })
    }

    /// A table that was made of something else at `path`.
    pub(super) fn made(path: &Path, header: Vec<String>, rows: Vec<csv::StringRecord>) -> Self {
        Self {
            path: path.to_owned(),
            header,
            rows,
        }
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is none; a sheet that was read has some.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Names of the columns.
    #[must_use]
    pub fn columns(&self) -> &[String] {
        &self.header
    }

    /// The place of a column.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<usize> {
        self.header.iter().position(|column| column == name)
    }

    /// The place of the first of these columns that there is.
    #[must_use]
    pub fn first_of(&self, names: &[&str]) -> Option<usize> {
        names.iter().find_map(|name| self.column(name))
    }

    /// A cell as text; empty if it is missing.
    #[must_use]
    pub fn text(&self, row: usize, column: usize) -> &str {
        self.rows
            .get(row)
            .and_then(|row| row.get(column))
            .map_or("", str::trim)
    }

    /// A cell as a finite number.
    #[must_use]
    pub fn number(&self, row: usize, column: usize) -> Option<f64> {
        let value: f64 = self.text(row, column).parse().ok()?;
        value.is_finite().then_some(value)
    }
}
