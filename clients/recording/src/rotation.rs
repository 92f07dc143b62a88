//! Rotation of recordings: one file per run and part, flushed by time, bounded in size.

// Numbers of a file or a device reach this arithmetic.
#![warn(clippy::arithmetic_side_effects)]

use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use mcap::records::Metadata;
use shm_schemas::{RunHeader, Stamp, TickInputs};

use super::clock::Clock;
use super::follower::Follower;
use super::origin::robot_metadata;
use super::writer::Writer;

/// Flush interval: the most that a sudden end of the recorder can lose. Design choice.
const FLUSH: Duration = Duration::from_secs(1);
/// Most bytes between two flushes, before compression. Design choice: less than a second at 1 kHz,
/// so that a run in lock-step, which is much faster, has the same bound.
const FLUSH_BYTES: u64 = 8 << 20;
/// Name of the metadata with the origin of a file.
pub(crate) const ORIGIN: &str = "atas.run";
/// Name of the metadata with the user's notes.
const NOTES: &str = "atas.notes";

/// Limits of bytes and files; `None` for no limit.
#[derive(Clone, Debug)]
pub struct Bounds {
    /// File size at which the next file begins.
    pub file_bytes: Option<u64>,
    /// Number of files to keep; the oldest is removed.
    pub files: Option<usize>,
    /// Size of all files at which the recording ends.
    pub total_bytes: Option<u64>,
}

/// Summary of a recording.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Parts of ticks written.
    pub parts: u64,
    /// Parts lost, by gaps in the sequence.
    pub lost: u64,
    /// True if each run was recorded from its first tick.
    pub has_beginning: bool,
    /// Remaining files, oldest first.
    pub files: Vec<PathBuf>,
    /// True if the recording ended because the byte budget was used up.
    pub is_full: bool,
    /// Size of all files, bytes.
    pub bytes: u64,
}

/// Recording in progress.
pub(super) struct Recording {
    out: PathBuf,
    bounds: Bounds,
    notes: BTreeMap<String, String>,
    writer: Writer,
    size: u64,
    closed: VecDeque<(PathBuf, u64)>,
    parts: u32,
    run: Option<Box<RunHeader>>,
    follower: Option<Box<dyn Follower>>,
    /// True while the follower can follow this run.
    is_followed: bool,
    /// Stamp of the last part.
    last: Stamp,
    next_sequence: Option<u64>,
    tally: Tally,
    flushed: Instant,
}

impl Recording {
    pub(super) fn create(
        out: &Path,
        bounds: Bounds,
        notes: BTreeMap<String, String>,
        follower: Option<Box<dyn Follower>>,
    ) -> anyhow::Result<Self> {
        Ok(Self {
            writer: Writer::create(out)?,
            out: out.to_owned(),
            bounds,
            notes,
            size: 0,
            closed: VecDeque::new(),
            parts: 0,
            run: None,
            follower,
            is_followed: false,
            last: Stamp::default(),
            next_sequence: None,
            tally: Tally {
                has_beginning: true,
                ..Tally::default()
            },
            flushed: Instant::now(),
        })
    }

    /// Returns the writer of the current file.
    pub(super) fn writer(&mut self) -> &mut Writer {
        &mut self.writer
    }

    /// Returns true if the daemon of this run publishes its inputs.
    pub(super) fn has_inputs(&self) -> bool {
        self.next_sequence.is_some()
    }

    /// Begins a run in a new file, unless it is the first run.
    pub(super) fn begin_run(&mut self, header: Box<RunHeader>) -> anyhow::Result<()> {
        self.update_follower(|follower| follower.begin(&header));
        if self.run.replace(header).is_some() {
            self.next_file()?;
        } else {
            self.write_origin()?;
        }
        self.next_sequence = None;
        Ok(())
    }

    /// Records a part of a tick.
    pub(super) fn inputs(&mut self, part: &TickInputs) -> anyhow::Result<()> {
        let sequence = part.stamp.sequence;
        match self.next_sequence {
            None => self.tally.has_beginning &= sequence == 0,
            Some(expected) => {
                let gap = sequence.saturating_sub(expected);
                self.tally.lost = self.tally.lost.saturating_add(gap);
            }
        }
        self.next_sequence = Some(sequence.saturating_add(1));
        self.tally.parts = self.tally.parts.saturating_add(1);
        self.last = part.stamp;
        if self.is_followed {
            self.update_follower(|follower| follower.update(part));
        }
        self.writer.write(part)
    }

    /// Passes data to the follower. If it fails, recording continues and one warning is logged.
    fn update_follower(&mut self, what: impl FnOnce(&mut dyn Follower) -> anyhow::Result<()>) {
        let Some(follower) = &mut self.follower else {
            return;
        };
        let followed = what(&mut **follower);
        self.is_followed = followed.is_ok();
        if let Err(error) = followed {
            tracing::warn!(
                "later files of this run cannot be replayed without those before them: {error:#}"
            );
        }
    }

    /// Flushes when due, and begins the next file when this one is large. Returns false when the
    /// disk budget is used up.
    pub(super) fn flush_and_rotate(&mut self) -> anyhow::Result<bool> {
        if self.flushed.elapsed() < FLUSH && self.writer.unflushed() < self.flush_bytes() {
            return Ok(true);
        }
        self.flushed = Instant::now();
        self.size = self.writer.flush()?;
        let is_large = self.bounds.file_bytes.is_some_and(|most| self.size >= most);
        if is_large && !self.is_within_tick() {
            self.next_file()?;
            self.write_state()?;
        }
        let sizes = self.closed.iter().map(|(_, size)| *size);
        let total = sizes.fold(self.size, u64::saturating_add);
        Ok(self.bounds.total_bytes.is_none_or(|bytes| total < bytes))
    }

    /// Returns the flush size. Small limits are checked as often as they can be reached.
    fn flush_bytes(&self) -> u64 {
        let bounds = [self.bounds.file_bytes, self.bounds.total_bytes];
        bounds.into_iter().flatten().fold(FLUSH_BYTES, u64::min)
    }

    /// Closes the last file.
    pub(super) fn finish(self) -> anyhow::Result<Tally> {
        let Self {
            mut closed,
            writer,
            mut tally,
            ..
        } = self;
        let path = writer.path().to_owned();
        closed.push_back((path, writer.finish()?));
        tally.bytes = closed
            .iter()
            .map(|(_, size)| *size)
            .fold(0, u64::saturating_add);
        tally.files = closed.into_iter().map(|(path, _)| path).collect();
        Ok(tally)
    }

    fn next_file(&mut self) -> anyhow::Result<()> {
        self.parts = self.parts.saturating_add(1);
        let next = Writer::create(&part(&self.out, self.parts))?;
        let full = std::mem::replace(&mut self.writer, next);
        let path = full.path().to_owned();
        self.closed.push_back((path, full.finish()?));
        self.size = 0;
        while self
            .bounds
            .files
            .is_some_and(|files| self.closed.len() >= files.max(1))
        {
            let Some((oldest, _)) = self.closed.pop_front() else {
                break;
            };
            // A file that another program removed needs no removal.
            let _ = std::fs::remove_file(oldest);
        }
        self.write_origin()
    }

    fn is_within_tick(&self) -> bool {
        let follower = self.follower.as_ref().filter(|_| self.is_followed);
        follower.is_some_and(|follower| follower.is_within_tick())
    }

    /// Writes the state from which the next part continues.
    fn write_state(&mut self) -> anyhow::Result<()> {
        let follower = self.follower.as_ref().filter(|_| self.is_followed);
        let state = follower.map(|follower| follower.state()).transpose()?;
        match state.flatten() {
            Some(state) => self.writer.write_state(&self.last, &state),
            None => Ok(()),
        }
    }

    /// Writes the origin of the file.
    fn write_origin(&mut self) -> anyhow::Result<()> {
        let Some(run) = &self.run else { return Ok(()) };
        if let Some(robot) = robot_metadata(run) {
            self.writer.describe(&robot)?;
        }
        self.writer.write(&**run)?;
        self.writer.describe(&origin(run, self.parts))?;
        if self.notes.is_empty() {
            return Ok(());
        }
        self.writer.describe(&Metadata {
            name: NOTES.to_owned(),
            metadata: self.notes.clone(),
        })
    }
}

/// Returns the name of a later file: `grasp.mcap`, `grasp-001.mcap`, …
fn part(out: &Path, number: u32) -> PathBuf {
    let text =
        |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let name = format!("{}-{number:03}", text(out.file_stem()));
    out.with_file_name(name)
        .with_extension(text(out.extension()))
}

fn origin(run: &RunHeader, part: u32) -> Metadata {
    let texts = [
        ("daemon_version", run.version.to_string()),
        ("recorder_version", env!("CARGO_PKG_VERSION").to_owned()),
        (
            "recorder_commit",
            option_env!("ATAS_COMMIT").unwrap_or("unknown").to_owned(),
        ),
        ("config_hash", format!("{:016x}", run.config_hash)),
        ("config", run.config.to_string()),
        ("robot", run.robot.to_string()),
        ("robot_hash", format!("{:016x}", run.robot_hash)),
        ("rate_hz", run.rate_hz.to_string()),
        ("daemon_started_ns", run.stamp.captured_ns.to_string()),
        ("writer_epoch", format!("{:016x}", run.stamp.writer_epoch)),
        ("part", part.to_string()),
    ];
    let texts = texts.into_iter().chain(Clock::now());
    Metadata {
        name: ORIGIN.to_owned(),
        metadata: texts.map(|(key, text)| (key.to_owned(), text)).collect(),
    }
}

#[cfg(test)]
#[allow(clippy::arithmetic_side_effects, reason = "numbers of the tests only")]
mod tests;
