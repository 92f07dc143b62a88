//! A recording over several files: one file per run and part, flushed by time, bounded in size.

use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use mcap::records::Metadata;
use shm_schemas::{RunHeader, Stamp, TickInputs};

use super::clock::Clock;
use super::follower::Follower;
use super::origin::robot_metadata;
use super::writer::Writer;

/// Longest time that a sudden end of the recorder can lose (ours).
const FLUSH: Duration = Duration::from_secs(1);
/// Most bytes between two flushes, before compression: less than a second at 1 kHz, so that a run in lock-step, which is
/// much faster, is bounded as finely (ours).
const FLUSH_BYTES: u64 = 8 << 20;
/// Name of the metadata that says where a file comes from.
pub(crate) const ORIGIN: &str = "atas.run";
/// Name of the metadata that hold what the user noted.
const NOTES: &str = "atas.notes";

/// How much may be written, bytes and files; `None` without a bound.
#[derive(Clone, Debug)]
pub struct Bounds {
    /// A file that is larger is followed by another one.
    pub file_bytes: Option<u64>,
    /// Files that are kept; the oldest is removed.
    pub files: Option<usize>,
    /// All files together; the recording ends when it is reached.
    pub total_bytes: Option<u64>,
}

/// What was recorded.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Parts of ticks written.
    pub parts: u64,
    /// Parts that the sequence says were lost.
    pub lost: u64,
    /// Whether each run was recorded from its first tick.
    pub has_beginning: bool,
    /// Files that remain, oldest first.
    pub files: Vec<PathBuf>,
    /// Whether the recording ended because its bytes were used up.
    pub is_full: bool,
    /// Their sizes together, bytes.
    pub bytes: u64,
}

/// A recording in the making.
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
    /// Whether the follower could follow this run so far.
    follows: bool,
    /// Timestamp of the last part.
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
            follows: false,
            last: Stamp::default(),
            next_sequence: None,
            tally: Tally {
                has_beginning: true,
                ..Tally::default()
            },
            flushed: Instant::now(),
        })
    }

    /// The file that is being written.
    pub(super) fn writer(&mut self) -> &mut Writer {
        &mut self.writer
    }

    /// Whether the daemon of this run says what its ticks take in.
    pub(super) fn has_inputs(&self) -> bool {
        self.next_sequence.is_some()
    }

    /// A daemon began a run: another file, unless this is the first.
    pub(super) fn begin_run(&mut self, header: Box<RunHeader>) -> anyhow::Result<()> {
        self.follow(|follower| follower.begin(&header));
        if self.run.replace(header).is_some() {
            self.next_file()?;
        } else {
            self.introduce()?;
        }
        self.next_sequence = None;
        Ok(())
    }

    /// A part of a tick.
    pub(super) fn inputs(&mut self, part: &TickInputs) -> anyhow::Result<()> {
        let sequence = part.stamp.sequence;
        match self.next_sequence {
            None => self.tally.has_beginning &= sequence == 0,
            Some(expected) => self.tally.lost += sequence.saturating_sub(expected),
        }
        self.next_sequence = Some(sequence + 1);
        self.tally.parts += 1;
        self.last = part.stamp;
        if self.follows {
            self.follow(|follower| follower.take(part));
        }
        self.writer.write(part)
    }

    /// What cannot be followed is recorded all the same, and told once.
    fn follow(&mut self, what: impl FnOnce(&mut dyn Follower) -> anyhow::Result<()>) {
        let Some(follower) = &mut self.follower else {
            return;
        };
        let followed = what(&mut **follower);
        self.follows = followed.is_ok();
        if let Err(error) = followed {
            tracing::warn!(
                "later files of this run cannot be replayed without those before them: {error:#}"
            );
        }
    }

    /// Flushes when it is time, and goes on in another file when this one is large. False when the disk budget is used
    /// up.
    pub(super) fn keep_up(&mut self) -> anyhow::Result<bool> {
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
        let total = self.closed.iter().map(|(_, size)| size).sum::<u64>() + self.size;
        Ok(self.bounds.total_bytes.is_none_or(|bytes| total < bytes))
    }

    /// Small bounds are looked at as often as they can be reached.
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
        tally.bytes = closed.iter().map(|(_, size)| size).sum();
        tally.files = closed.into_iter().map(|(path, _)| path).collect();
        Ok(tally)
    }

    fn next_file(&mut self) -> anyhow::Result<()> {
        self.parts += 1;
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
            // A file that someone else removed is removed as well.
            let _ = std::fs::remove_file(oldest);
        }
        self.introduce()
    }

    fn is_within_tick(&self) -> bool {
        let follower = self.follower.as_ref().filter(|_| self.follows);
        follower.is_some_and(|follower| follower.is_within_tick())
    }

    /// Writes what the run's next part goes on from.
    fn write_state(&mut self) -> anyhow::Result<()> {
        let follower = self.follower.as_ref().filter(|_| self.follows);
        let state = follower.map(|follower| follower.state()).transpose()?;
        match state.flatten() {
            Some(state) => self.writer.write_state(&self.last, &state),
            None => Ok(()),
        }
    }

    /// Writes where the file comes from.
    fn introduce(&mut self) -> anyhow::Result<()> {
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

/// The name of a later file: `grasp.mcap`, `grasp-001.mcap`, …
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
mod tests;
