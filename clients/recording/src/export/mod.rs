//! Recordings for other people's programs.
//!
//! ```text
//!  Rows ─▶ export ─┬─ messages (ros, cdr) ─▶ mcap: Rerun, Foxglove, PlotJuggler
//!                  └─ table ─▶ csv, parquet: one row per tick, for notebooks
//! ```
//!
//! One thread reads, another writes. [`Messages`] serves what happens now as well, to whoever takes them ([`Outlet`]).
//!
//! * **Invariants:** sensor time becomes wall-clock time by one offset for the whole run ([`crate::Clock`]). A file never
//!   overwrites another, and has its name only once it is whole ([`draft`]). What was not recorded is left out, not made up.
//! * **Absent on purpose:** what replays: that is the recording itself.

mod cdr;
mod csv;
mod draft;
mod mcap;
mod messages;
mod parquet;
mod ros;
mod subject;
mod table;

use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};

use anyhow::Context;

use crate::rows::{Row, Rows};
use draft::Draft;
pub use messages::{Messages, Outlet};
pub use ros::MessageType;
pub use subject::Subject;

/// Rows that may wait between the reading and the writing thread (ours: half a second, some 8 MiB).
const WAITING: usize = 512;

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

/// A file in the making.
trait Sink {
    fn row(&mut self, row: &Row) -> anyhow::Result<()>;
    fn finish(self: Box<Self>) -> anyhow::Result<()>;
}

/// Exports the files of one run into a new file, until the end or until `stop` is set.
///
/// # Errors
/// The recording cannot be read to its end, or the file cannot be written: then there is none.
pub fn export(
    files: &[PathBuf],
    out: &Path,
    choices: &Choices,
    stop: &AtomicBool,
) -> anyhow::Result<Exported> {
    let rows = Rows::open(files)?;
    let subject = Subject::recorded(&rows)?;
    let draft = Draft::beside(out)?;
    let mut sink = sink(&draft, choices, subject)?;
    let (send, receive) = sync_channel(WAITING);
    let exported = std::thread::scope(|scope| {
        scope.spawn(move || {
            let wanted = |_: &_| !stop.load(Ordering::Relaxed);
            // The other end is gone when it could not write.
            rows.take_while(wanted).all(|row| send.send(row).is_ok());
        });
        write(receive, &mut *sink)
    });
    let exported = exported.with_context(|| format!("could not export into {}", out.display()))?;
    let finished = sink.finish();
    finished.with_context(|| format!("could not write {}", out.display()))?;
    draft.publish()?;
    Ok(exported)
}

fn write(rows: Receiver<anyhow::Result<Row>>, sink: &mut dyn Sink) -> anyhow::Result<Exported> {
    let mut exported = Exported::default();
    let mut first_ns = None;
    for row in rows {
        let row = row?;
        let first_ns = *first_ns.get_or_insert(row.captured_ns);
        exported.ticks += 1;
        exported.seconds = row.captured_ns.saturating_sub(first_ns) as f64 * 1e-9;
        sink.row(&row)?;
    }
    Ok(exported)
}

fn sink(draft: &Draft, choices: &Choices, subject: Subject) -> anyhow::Result<Box<dyn Sink>> {
    let file = BufWriter::new(draft.open()?);
    Ok(match choices.kind {
        Kind::Mcap => Box::new(mcap::Mcap::new(file, subject, choices.pictures_hz)?),
        Kind::Csv => Box::new(csv::Csv::new(file, &subject, choices.elements)?),
        Kind::Parquet => Box::new(parquet::Parquet::new(file, &subject, choices.elements)?),
    })
}

#[cfg(test)]
mod tests;
