//! Table of comma-separated values in memory. Columns may be missing, cells empty or not numeric.

use std::io::Read;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};

/// Maximum number of rows, which limits memory use. Design choice: a day at 100 Hz.
const ROWS_MAX: usize = 10_000_000;

/// A table with a header.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// Path of the source, for messages.
    pub path: PathBuf,
    header: Vec<String>,
    rows: Vec<csv::StringRecord>,
}

impl Sheet {
    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be opened, is not a table, or has no rows.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let file = std::fs::File::open(path)
            .with_context(|| format!("could not open {}", path.display()))?;
        Self::read(path, std::io::BufReader::new(file))
    }

    /// Reads a table from a reader; `path` is its name in messages.
    pub fn read(path: &Path, source: impl Read) -> anyhow::Result<Self> {
        let name = path.display();
        // Shorter rows count as rows with empty cells.
        let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(source);
        let header = reader
            .headers()
            .with_context(|| format!("could not read {name} as a table"))?;
        let header: Vec<String> = header.iter().map(|cell| cell.trim().to_owned()).collect();
        let mut rows = Vec::new();
        for row in reader.records() {
            rows.push(row.with_context(|| {
                format!(
                    "could not read {name} beyond row {}; check that it is comma-separated text",
                    rows.len() + 1
                )
            })?);
            ensure!(
                rows.len() <= ROWS_MAX,
                "could not read {name}: it has more than {ROWS_MAX} rows; split it"
            );
        }
        ensure!(
            !rows.is_empty(),
            "could not evaluate {name}: it has no rows; it needs a line of column names and one \
             row per frame"
        );
        Ok(Self {
            path: path.to_owned(),
            header,
            rows,
        })
    }

    pub(super) fn from_rows(
        path: &Path,
        header: Vec<String>,
        rows: Vec<csv::StringRecord>,
    ) -> Self {
        Self {
            path: path.to_owned(),
            header,
            rows,
        }
    }

    /// Returns the number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Returns true without rows; never for a table that was read.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Returns the names of the columns.
    #[must_use]
    pub fn columns(&self) -> &[String] {
        &self.header
    }

    /// Returns the index of a column.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<usize> {
        self.header.iter().position(|column| column == name)
    }

    /// Returns the index of the first existing column of these names.
    #[must_use]
    pub fn first_of(&self, names: &[&str]) -> Option<usize> {
        names.iter().find_map(|name| self.column(name))
    }

    /// Returns a cell as text; empty if missing.
    #[must_use]
    pub fn text(&self, row: usize, column: usize) -> &str {
        self.rows
            .get(row)
            .and_then(|row| row.get(column))
            .map_or("", str::trim)
    }

    /// Returns a cell as a finite number.
    #[must_use]
    pub fn number(&self, row: usize, column: usize) -> Option<f64> {
        let value: f64 = self.text(row, column).parse().ok()?;
        value.is_finite().then_some(value)
    }
}
