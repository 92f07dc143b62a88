//! Readings as comma-separated values, one line per frame: what `--dry-run` prints.
//!
//! Columns: `byte_offset,count,status`, the values in counts (`fx_counts,…`; with four channels `fx0_counts,…`; with
//! six axes also `tx_counts,…`), `arrival`, `captured_ns`, and per channel `normal_n,tangential1_n,tangential2_n` where
//! a scale is known. Every valid frame has a line, duplicates and late ones too.

use std::io::{self, BufWriter, Write};

use super::{Health, Output, Reading};
use crate::failure::Failure;
use crate::mapping::Mapping;
use crate::wire::optoforce::Kind;

/// Writes the table.
#[derive(Debug)]
pub struct Table<W: Write> {
    sink: BufWriter<W>,
    mapping: Option<Mapping>,
}

impl<W: Write> Table<W> {
    /// Begins a table with its header line.
    ///
    /// # Errors
    /// When the sink is gone.
    pub fn new(sink: W, kind: Kind, mapping: Option<Mapping>) -> Result<Self, Failure> {
        let mut table = Self {
            sink: BufWriter::new(sink),
            mapping,
        };
        table
            .header(kind)
            .and_then(|()| table.sink.flush())
            .map_err(Failure::Table)?;
        Ok(table)
    }

    fn header(&mut self, kind: Kind) -> io::Result<()> {
        let channels: &[&str] = if kind == Kind::FourChannel {
            &["0", "1", "2", "3"]
        } else {
            &[""]
        };
        write!(self.sink, "byte_offset,count,status")?;
        for channel in channels {
            write!(
                self.sink,
                ",fx{channel}_counts,fy{channel}_counts,fz{channel}_counts"
            )?;
        }
        if kind == Kind::SixAxis {
            write!(self.sink, ",tx_counts,ty_counts,tz_counts")?;
        }
        write!(self.sink, ",arrival,captured_ns")?;
        for channel in channels.iter().filter(|_| self.mapping.is_some()) {
            write!(
                self.sink,
                ",normal{channel}_n,tangential1{channel}_n,tangential2{channel}_n"
            )?;
        }
        writeln!(self.sink)
    }

    fn line(&mut self, reading: &Reading) -> io::Result<()> {
        let frame = &reading.frame;
        write!(
            self.sink,
            "{},{},{}",
            frame.byte_offset, frame.count, frame.status.0
        )?;
        for value in frame.values() {
            write!(self.sink, ",{value}")?;
        }
        write!(
            self.sink,
            ",{},{}",
            reading.arrival.name(),
            reading.captured_ns
        )?;
        if let Some(mapping) = self.mapping {
            for [normal_n, tangential1_n, tangential2_n] in
                frame.forces().map(|counts| mapping.force_n(counts))
            {
                write!(self.sink, ",{normal_n},{tangential1_n},{tangential2_n}")?;
            }
        }
        writeln!(self.sink)
    }
}

impl<W: Write> Output for Table<W> {
    fn readings(&mut self, readings: &[Reading]) -> Result<(), Failure> {
        readings
            .iter()
            .try_for_each(|reading| self.line(reading))
            .map_err(Failure::Table)?;
        self.sink.flush().map_err(Failure::Table)
    }

    fn health(&mut self, _health: &Health) -> Result<(), Failure> {
        Ok(())
    }
}
