//! Frames from a table of `--dry-run`: its forces in newtons and its times.
//!
//! A table lists neither the fingertips of its elements nor the status of the device. All
//! fingertips have the same number of elements, and every number counts as valid. Duplicate and
//! late frames are skipped; lost frames appear only as gaps in time.

use std::fs::File;
use std::path::Path;

use shm_schemas::capacity::{ELEMENTS, FINGERS};
use shm_schemas::{Hand, HandFrame, Stamp};

use crate::plan;

/// Epoch of the recorded frames; any value works.
const EPOCH: u64 = 1;

/// Table being read.
pub(super) struct Table {
    rows: csv::StringRecordsIntoIter<File>,
    name: String,
    captured: usize,
    arrival: Option<usize>,
    /// Columns of the normal and tangential forces of every element, fingertip by fingertip.
    elements: Vec<[usize; 3]>,
    /// Data common to all frames.
    frame: HandFrame,
    fingers: usize,
    valid: u64,
    row: u64,
    next_sequence: u64,
}

impl Table {
    pub(super) fn open(
        path: &Path,
        hand: Hand,
        fingers: Option<usize>,
        layout: Option<&str>,
    ) -> Result<Self, String> {
        let name = path.display().to_string();
        let refuse = |reason: &str| format!("could not play {name}: {reason}");
        let mut reader =
            csv::Reader::from_path(path).map_err(|error| refuse(&error.to_string()))?;
        let header = reader
            .headers()
            .map_err(|error| refuse(&error.to_string()))?;
        let column = |name: &str| header.iter().position(|column| column == name);
        let elements = elements(column);
        let captured = column("captured_ns").filter(|_| !elements.is_empty());
        let captured = captured.ok_or_else(|| {
            refuse(
                "it is neither a recording of `atas record` nor a table of `atas-sensor SENSOR --dry-run` with forces in newtons, \
                 which needs --newtons-per-count or --calibration",
            )
        })?;
        let fingers = fingers.unwrap_or(1);
        let each = elements.len() / fingers.clamp(1, FINGERS);
        if each * fingers != elements.len() || each > ELEMENTS {
            return Err(refuse(&format!(
                "{} elements do not divide into {fingers} fingertips; set their number with \
                 --fingers",
                elements.len()
            )));
        }
        let layout = plan::layout(layout, each).map_err(|failure| failure.to_string())?;
        Ok(Self {
            captured,
            arrival: column("arrival"),
            elements,
            frame: HandFrame {
                layout_hash: layout.hash(),
                hand,
                finger_count: fingers as u32,
                ..HandFrame::default()
            },
            fingers,
            valid: u64::MAX >> (64 - layout.count.clamp(1, 64)),
            rows: reader.into_records(),
            row: 0,
            next_sequence: 0,
            name,
        })
    }

    /// Returns the frame of a row; `None` if it is not newer than all before.
    fn frame(&mut self, row: &csv::StringRecord) -> Result<Option<HandFrame>, String> {
        self.row += 1;
        let is_old = |arrival: usize| matches!(row.get(arrival), Some("duplicate" | "late"));
        if self.arrival.is_some_and(is_old) {
            return Ok(None);
        }
        let cell = |column: usize| row.get(column).unwrap_or_default();
        let captured_ns = cell(self.captured).parse();
        let Ok(captured_ns) = captured_ns else {
            return Err(format!(
                "could not play {} after row {}: its captured_ns is {:?}",
                self.name,
                self.row,
                cell(self.captured)
            ));
        };
        let mut frame = self.frame;
        let each = self.elements.len() / self.fingers;
        for (finger, columns) in self.elements.chunks_exact(each).enumerate() {
            frame.valid_mask[finger] = self.valid;
            for (element, axes) in columns.iter().enumerate() {
                let force_n = axes.map(|axis| cell(axis).parse().unwrap_or(f32::NAN));
                if force_n.iter().all(|n| n.is_finite()) {
                    frame.force_n[finger][element] = force_n;
                } else {
                    frame.valid_mask[finger] &= !(1 << element);
                }
            }
        }
        frame.stamp = Stamp {
            sequence: self.next_sequence,
            captured_ns,
            writer_epoch: EPOCH,
        };
        self.next_sequence += 1;
        frame.seal();
        Ok(Some(frame))
    }
}

/// Returns the columns of the forces: without a number for one element, numbered from 0 for
/// several.
fn elements(column: impl Fn(&str) -> Option<usize>) -> Vec<[usize; 3]> {
    let axes = |element: &str| -> Option<[usize; 3]> {
        let axis = |name: &str| column(&format!("{name}{element}_n"));
        Some([axis("normal")?, axis("tangential1")?, axis("tangential2")?])
    };
    match axes("") {
        Some(only) => vec![only],
        None => (0..)
            .map_while(|element: usize| axes(&element.to_string()))
            .collect(),
    }
}

impl Iterator for Table {
    type Item = Result<HandFrame, String>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let row = match self.rows.next()? {
                Ok(row) => row,
                Err(error) => {
                    return Some(Err(format!(
                        "could not play {} after row {}: {error}",
                        self.name, self.row
                    )));
                }
            };
            match self.frame(&row).transpose() {
                None => {}
                Some(next) => return Some(next),
            }
        }
    }
}
