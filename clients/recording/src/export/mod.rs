//! Recordings for other people's programs.
//!
//! ```text
//!  Rows ─▶ Export ─┬─ mcap    ROS 2 messages (ros, cdr): Rerun, Foxglove, PlotJuggler
//!                  └─ table ─▶ csv, parquet: one row per tick, for notebooks
//! ```
//!
//! * **Invariants:** sensor time becomes wall-clock time by one offset for the whole run ([`crate::Clock`]). A file never
//!   overwrites another. What was not recorded is left out, not made up.
//! * **Absent on purpose:** what replays: that is the recording itself.

mod cdr;
mod csv;
mod mcap;
mod parquet;
mod ros;
mod table;

use std::fs::{File, OpenOptions};
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use robot_model::{Side, Skeleton};
use shm_schemas::Layout;

use crate::clock::Clock;
use crate::origin;
use crate::rows::{Row, Rows};

/// What an exported file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// ROS 2 messages in an MCAP file.
    Mcap,
    /// Comma-separated values.
    Csv,
    /// Columns in an Apache Parquet file.
    Parquet,
}

/// How to export.
#[derive(Clone, Copy, Debug)]
pub struct Choices {
    /// Which file.
    pub kind: Kind,
    /// Transforms and point clouds per second of an MCAP file; everything else comes with every tick.
    pub pictures_hz: f64,
    /// Whether a table has a column for every component of every element.
    pub elements: bool,
}

/// What was exported.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exported {
    /// Ticks.
    pub ticks: u64,
    /// From the first to the last of them, s.
    pub seconds: f64,
}

/// What a file is written about: the robot, its sensors, the clock.
struct Subject {
    urdf: String,
    skeleton: Skeleton,
    /// Names of the links that carry the fingertips, per hand.
    tips: [Vec<String>; 2],
    layouts: [Layout; 2],
    fingers: [usize; 2],
    clock: Clock,
    /// Version of the daemon and hash of its configuration.
    made_by: [(&'static str, String); 2],
}

/// A file in the making.
trait Sink {
    fn row(&mut self, row: &Row) -> anyhow::Result<()>;
    fn finish(self: Box<Self>) -> anyhow::Result<()>;
}

/// Exports the files of one run into a new file, until the end or until `stop` is set.
///
/// # Errors
/// The recording cannot be read to its end, or the file cannot be written. What came before is in the file.
pub fn export(
    files: &[PathBuf],
    out: &Path,
    choices: &Choices,
    stop: &AtomicBool,
) -> anyhow::Result<Exported> {
    let mut rows = Rows::open(files)?;
    let subject = Subject::of(&rows)?;
    let mut sink = sink(out, choices, subject)?;
    let mut exported = Exported::default();
    let mut first_ns = None;
    let mut read = rows.by_ref().take_while(|_| !stop.load(Ordering::Relaxed));
    let written = read.try_for_each(|row| {
        let row = row?;
        let first_ns = *first_ns.get_or_insert(row.captured_ns);
        exported.ticks += 1;
        exported.seconds = row.captured_ns.saturating_sub(first_ns) as f64 * 1e-9;
        sink.row(&row)
            .with_context(|| format!("could not write {}", out.display()))
    });
    // Also what ends early is a whole file.
    sink.finish()
        .with_context(|| format!("could not write {}", out.display()))?;
    written.map(|()| exported)
}

fn sink(out: &Path, choices: &Choices, subject: Subject) -> anyhow::Result<Box<dyn Sink>> {
    let file = OpenOptions::new().write(true).create_new(true).open(out);
    let file = file.with_context(|| format!("could not make the file {}", out.display()))?;
    let file: BufWriter<File> = BufWriter::new(file);
    Ok(match choices.kind {
        Kind::Mcap => Box::new(mcap::Mcap::new(file, subject, choices.pictures_hz)?),
        Kind::Csv => Box::new(csv::Csv::new(file, &subject, choices.elements)?),
        Kind::Parquet => Box::new(parquet::Parquet::new(file, &subject, choices.elements)?),
    })
}

impl Subject {
    fn of(rows: &Rows) -> anyhow::Result<Self> {
        let header = rows.header();
        let files = origin::robot(header)?;
        let skeleton = files
            .skeleton()
            .context("could not load the recorded robot")?;
        let robot = files.load().context("could not load the recorded robot")?;
        let tips = |side| robot.hand(side).tip_links().map(str::to_owned).collect();
        let text = |text: Option<String>| text.unwrap_or_else(|| "not recorded".to_owned());
        Ok(Self {
            urdf: files.urdf.into_owned(),
            skeleton,
            tips: Side::BOTH.map(tips),
            layouts: origin::layouts(header),
            fingers: origin::fingers(header),
            clock: rows.clock(),
            made_by: [
                (
                    "atas.daemon_version",
                    text(header.map(|h| h.version.to_string())),
                ),
                (
                    "atas.config_hash",
                    text(header.map(|h| format!("{:016x}", h.config_hash))),
                ),
            ],
        })
    }
}

#[cfg(test)]
mod tests;
