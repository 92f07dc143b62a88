//! Readings as comma-separated values, one line per frame: the output of `--dry-run`.
//!
//! Columns: `byte_offset,count,status`; the values in the device's unit (`fx_counts,…`; with
//! several taxels `fx0_counts,…`); `arrival`, `captured_ns`; of magnetometers `temperature_c`; with
//! a known scale, per taxel `normal_n,tangential1_n,tangential2_n`. Every valid frame has a line,
//! including duplicates and late ones. `count` is empty for a device without a counter.

use std::io::{self, BufWriter, Write};

use shm_schemas::capacity::ELEMENTS;

use crate::failure::Failure;
use crate::newtons::Newtons;
use crate::reading::{Batch, Health, Output, Reading, Shape};

/// Writer of the table.
#[derive(Debug)]
pub struct Table<W: Write> {
    sink: BufWriter<W>,
    shape: Shape,
    newtons: Option<Newtons>,
}

impl<W: Write> Table<W> {
    /// Begins a table with its header line.
    ///
    /// # Errors
    /// The output is closed.
    pub fn new(sink: W, shape: Shape, newtons: Option<Newtons>) -> Result<Self, Failure> {
        let mut table = Self {
            sink: BufWriter::new(sink),
            shape,
            // Forces beyond the capacity of a frame are printed without conversion.
            newtons: newtons.filter(|newtons| newtons.elements(shape) <= ELEMENTS),
        };
        table
            .header()
            .and_then(|()| table.sink.flush())
            .map_err(Failure::Table)?;
        Ok(table)
    }

    fn header(&mut self) -> io::Result<()> {
        let Shape {
            quantity,
            unit,
            fingers,
            taxels,
        } = self.shape;
        let groups: Vec<String> = match fingers * taxels {
            1 => vec![String::new()],
            several => (0..several).map(|group| group.to_string()).collect(),
        };
        write!(self.sink, "byte_offset,count,status")?;
        for group in &groups {
            for axis in quantity.axes() {
                write!(self.sink, ",{axis}{group}_{unit}")?;
            }
        }
        write!(self.sink, ",arrival,captured_ns")?;
        if quantity.has_temperature() {
            write!(self.sink, ",temperature_c")?;
        }
        let forces = self
            .newtons
            .as_ref()
            .map_or(0, |newtons| fingers * newtons.elements(self.shape));
        for group in 0..forces {
            let group = if forces == 1 {
                String::new()
            } else {
                group.to_string()
            };
            write!(
                self.sink,
                ",normal{group}_n,tangential1{group}_n,tangential2{group}_n"
            )?;
        }
        writeln!(self.sink)
    }

    fn line(&mut self, reading: &Reading, values: &[f64]) -> io::Result<()> {
        write!(self.sink, "{},", reading.byte_offset)?;
        if let Some(count) = reading.count {
            write!(self.sink, "{count}")?;
        }
        write!(self.sink, ",{}", reading.status)?;
        for &value in values {
            // Values from f32 are printed as f32, without unmeasured digits.
            if f64::from(value as f32) == value {
                write!(self.sink, ",{}", value as f32)?;
            } else {
                write!(self.sink, ",{value}")?;
            }
        }
        write!(
            self.sink,
            ",{},{}",
            reading.arrival.name(),
            reading.captured_ns
        )?;
        let quantity = self.shape.quantity;
        if quantity.has_temperature() {
            write!(self.sink, ",")?;
            if let Some(temperature_c) = reading.temperature_c {
                write!(self.sink, "{temperature_c:.3}")?;
            }
        }
        if let Some(newtons) = &self.newtons {
            let tips = values.chunks_exact(quantity.axes().len() * self.shape.taxels);
            for (tip, values) in tips.enumerate() {
                let mut forces_n = [[0.0; 3]; ELEMENTS];
                let count = newtons.write(tip, quantity, values, &mut forces_n);
                for [normal_n, tangential1_n, tangential2_n] in &forces_n[..count] {
                    write!(self.sink, ",{normal_n},{tangential1_n},{tangential2_n}")?;
                }
            }
        }
        writeln!(self.sink)
    }
}

impl<W: Write> Output for Table<W> {
    fn readings(&mut self, batch: &Batch) -> Result<(), Failure> {
        batch
            .iter()
            .try_for_each(|(reading, values)| self.line(reading, values))
            .and_then(|()| self.sink.flush())
            .map_err(Failure::Table)
    }

    fn health(&mut self, _health: &Health) -> Result<(), Failure> {
        Ok(())
    }
}
