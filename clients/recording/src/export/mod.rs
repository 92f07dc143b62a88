//! Export of recordings for other programs.
//!
//! ```text
//!  Rows ─▶ export ─┬─ messages (ros, cdr) ─▶ mcap: Rerun, Foxglove, PlotJuggler
//!                  └─ table ─▶ csv, parquet: one row per tick, for notebooks
//! ```
//!
//! One thread reads, another writes. [`Messages`] also serves live data, to any [`Outlet`].
//!
//! * **Invariants:** one offset for the whole run converts sensor time to wall-clock time
//!   ([`crate::Clock`]). A file never overwrites another and has its name only when complete
//!   ([`draft`]). Data that were not recorded are left out.
//! * **Not included:** replay, which needs the recording itself.

mod cdr;
mod csv;
mod draft;
mod lerobot;
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
pub use lerobot::{Dataset, DatasetChoices, export_dataset};
pub use messages::{Messages, Outlet};
pub use ros::MessageType;
pub use subject::Subject;

/// Rows between the reading and the writing thread. Design choice: half a second, about 8 MiB.
const ROWS_IN_CHANNEL: usize = 512;

/// Format of an exported file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// ROS 2 messages in an MCAP file.
    Mcap,
    /// Comma-separated values.
    Csv,
    /// Columns in an Apache Parquet file.
    Parquet,
}

/// Export options.
#[derive(Clone, Copy, Debug)]
pub struct Choices {
    /// Format.
    pub kind: Kind,
    /// Transforms and point clouds per second in an MCAP file; other data come with every tick.
    pub pictures_hz: f64,
    /// True for a column per component of every element.
    pub elements: bool,
}

/// Summary of an export.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exported {
    /// Ticks.
    pub ticks: u64,
    /// Time from the first to the last tick, s.
    pub seconds: f64,
}

/// File being written.
trait Sink {
    fn row(&mut self, row: &Row) -> anyhow::Result<()>;
    fn finish(self: Box<Self>) -> anyhow::Result<()>;
}

/// Exports the files of one run into a new file, until the end or until `stop` is set.
///
/// # Errors
/// The recording cannot be read to its end, or the file cannot be written. No file is created then.
pub fn export(
    files: &[PathBuf],
    out: &Path,
    choices: &Choices,
    stop: &AtomicBool,
) -> anyhow::Result<Exported> {
    let rows = Rows::open(files)?;
    let subject = Subject::recorded(&rows)?;
    let draft = Draft::next_to(out)?;
    let mut sink = sink(&draft, choices, subject)?;
    let (send, receive) = sync_channel(ROWS_IN_CHANNEL);
    let exported = std::thread::scope(|scope| {
        scope.spawn(move || {
            let wanted = |_: &_| !stop.load(Ordering::Relaxed);
            // The receiver is gone after a write error.
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
