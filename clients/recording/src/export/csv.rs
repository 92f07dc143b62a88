//! Comma-separated values: a header line, then a line per tick. An empty cell means not recorded.

use std::fs::File;
use std::io::{BufWriter, Write};

use super::Sink;
use super::subject::Subject;
use super::table::{Cell, Column, columns};
use crate::rows::Row;

/// CSV file.
pub(super) struct Csv {
    file: BufWriter<File>,
    columns: Vec<Column>,
}

impl Csv {
    pub(super) fn new(
        mut file: BufWriter<File>,
        subject: &Subject,
        elements: bool,
    ) -> anyhow::Result<Self> {
        let columns = columns(subject, elements);
        let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        writeln!(file, "{}", names.join(","))?;
        Ok(Self { file, columns })
    }
}

impl Sink for Csv {
    fn row(&mut self, row: &Row) -> anyhow::Result<()> {
        for (index, column) in self.columns.iter().enumerate() {
            if index > 0 {
                self.file.write_all(b",")?;
            }
            // No name or word contains a comma or a quotation mark (tested).
            match column.cell(row) {
                Cell::Empty => {}
                Cell::Whole(value) => write!(self.file, "{value}")?,
                Cell::Number(value) => write!(self.file, "{value}")?,
                Cell::Short(value) => write!(self.file, "{value}")?,
                Cell::Text(text) => self.file.write_all(text.as_bytes())?,
            }
        }
        self.file.write_all(b"\n")?;
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> anyhow::Result<()> {
        self.file.flush()?;
        Ok(())
    }
}
