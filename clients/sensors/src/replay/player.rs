//! Player: publishes frames at their times, with new stamps.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::Duration;

use shm_bus::{BusName, now_ns};
use shm_schemas::{HandFrame, Stamp};

use super::{Frames, Pace, Source, Timeline};
use crate::failure::Failure;
use crate::port::{READ_TIMEOUT, REPORT_EVERY};
use crate::reading::Health;
use crate::writer::{BURST, BURST_PAUSE, HandWriter};

/// Frames read ahead. Design choice: half a second at 1 kHz, longer than decompressing a chunk of a
/// recording.
const FRAMES_AHEAD: usize = 512;
/// Delay of a frame at which all later times are shifted, ns. Design choice: the buffer of a bus
/// reader at 1 kHz.
const DELAY_MAX_NS: u64 = 50_000_000;

/// Summary of a replay.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReplaySummary {
    /// Frames.
    pub frames: u64,
    /// Frames lost during recording.
    pub lost: u64,
    /// Recorded frames that were skipped: damaged, or not newer than all before.
    pub skipped: u64,
    /// Number of times that this machine was too slow.
    pub delays: u64,
}

impl fmt::Display for ReplaySummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            frames,
            lost,
            skipped: left_out,
            delays,
        } = self;
        write!(
            f,
            "{frames} frames played, {lost} lost when recorded, {left_out} skipped, {delays} delays"
        )
    }
}

/// Plays to the end, repeatedly with `again`, or until a stop request. The summary is valid in
/// every case.
///
/// # Errors
/// [`Failure::Recording`] or [`Failure::Usage`] before the first frame,
/// [`Failure::RecordingDamaged`] at damage, [`Failure::Bus`].
pub fn play(
    source: &Source,
    pace: Pace,
    again: bool,
    bus: &BusName,
    stop: &AtomicBool,
) -> (ReplaySummary, Result<(), Failure>) {
    let opened = source.check().and_then(|()| {
        let name = source.name();
        HandWriter::open(bus, source.hand, [("replay", &*name)].into_iter())
    });
    let writer = match opened {
        Ok(writer) => writer,
        Err(failure) => return (ReplaySummary::default(), Err(failure)),
    };
    let mut player = Player {
        writer,
        timeline: Timeline::new(pace),
        source,
        stop,
        played: ReplaySummary::default(),
        next_sequence: 0,
        due_ns: now_ns(),
        at_once: 0,
        next_report_ns: 0,
    };
    let outcome = thread::scope(|scope| {
        let (to, from) = sync_channel(FRAMES_AHEAD);
        scope.spawn(move || read(source, again, &to));
        // The player owns the receiver: when it ends, the reading thread ends.
        player.run(from)
    });
    let goodbye = player.report(false);
    (player.played, outcome.and(goodbye))
}

/// Message of the reading thread.
enum ReaderMessage {
    Frame(Box<HandFrame>),
    NextRound,
    Failure(Failure),
}

/// Reads until the end, or until the receiver is gone.
fn read(source: &Source, again: bool, to: &SyncSender<ReaderMessage>) {
    loop {
        let failure = match source.frames() {
            Ok(frames) => match read_round(frames, to) {
                Ok(()) if !again => return,
                Ok(()) => None,
                Err(reason) => Some(Failure::RecordingDamaged(reason)),
            },
            Err(failure) => Some(failure),
        };
        let is_over = failure.is_some();
        let parcel = failure.map_or(ReaderMessage::NextRound, ReaderMessage::Failure);
        if to.send(parcel).is_err() || is_over {
            return;
        }
    }
}

fn read_round(frames: Frames, to: &SyncSender<ReaderMessage>) -> Result<(), String> {
    for frame in frames {
        if to.send(ReaderMessage::Frame(Box::new(frame?))).is_err() {
            break;
        }
    }
    Ok(())
}

struct Player<'a> {
    writer: HandWriter,
    timeline: Timeline,
    source: &'a Source,
    stop: &'a AtomicBool,
    played: ReplaySummary,
    next_sequence: u64,
    /// Due time of the last frame.
    due_ns: u64,
    /// Frames since the last pause.
    at_once: usize,
    next_report_ns: u64,
}

impl Player<'_> {
    fn run(&mut self, from: Receiver<ReaderMessage>) -> Result<(), Failure> {
        self.report_when_due(now_ns())?;
        while !self.is_stopped() {
            match from.recv_timeout(READ_TIMEOUT) {
                Ok(ReaderMessage::Frame(frame)) => self.publish(*frame)?,
                Ok(ReaderMessage::NextRound) => self.timeline.begin_round(),
                Ok(ReaderMessage::Failure(failure)) => return Err(failure),
                Err(RecvTimeoutError::Timeout) => self.report_when_due(now_ns())?,
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        Ok(())
    }

    fn publish(&mut self, mut frame: HandFrame) -> Result<(), Failure> {
        let step = Some(frame.stamp).filter(|_| frame.is_intact());
        let Some(step) = step.and_then(|stamp| self.timeline.step(stamp)) else {
            self.played.skipped += 1;
            return Ok(());
        };
        self.due_ns = self.due_ns.saturating_add(step.after_ns);
        if !self.wait()? {
            return Ok(());
        }
        self.next_sequence = self.next_sequence.saturating_add(step.advance);
        frame.hand = self.source.hand;
        frame.stamp = Stamp {
            writer_epoch: self.writer.epoch(),
            sequence: self.next_sequence - 1,
            captured_ns: self.due_ns,
        };
        frame.seal();
        self.writer.frame(&frame)?;
        self.played.frames += 1;
        self.played.lost = self.played.lost.saturating_add(step.advance - 1);
        Ok(())
    }

    /// Waits until the frame is due. Returns false after a stop request.
    fn wait(&mut self) -> Result<bool, Failure> {
        while !self.is_stopped() {
            let now_ns = now_ns();
            self.report_when_due(now_ns)?;
            if now_ns >= self.due_ns {
                self.catch_up(now_ns);
                return Ok(true);
            }
            thread::sleep(Duration::from_nanos(self.due_ns - now_ns).min(READ_TIMEOUT));
            self.at_once = 0;
        }
        Ok(false)
    }

    /// Sends late frames at once, but not more than a reader can buffer, and with a recent stamp.
    fn catch_up(&mut self, now_ns: u64) {
        self.at_once += 1;
        if self.at_once.is_multiple_of(BURST) {
            thread::sleep(BURST_PAUSE);
        }
        if now_ns - self.due_ns > DELAY_MAX_NS {
            self.played.delays += 1;
            self.due_ns = now_ns;
        }
    }

    fn report_when_due(&mut self, now_ns: u64) -> Result<(), Failure> {
        if now_ns < self.next_report_ns {
            return Ok(());
        }
        self.next_report_ns = now_ns + REPORT_EVERY.as_nanos() as u64;
        self.report(true)
    }

    fn report(&mut self, alive: bool) -> Result<(), Failure> {
        let mut health = Health {
            alive,
            ..Health::default()
        };
        health.bytes.frames = self.played.frames;
        health.continuity.lost = self.played.lost;
        self.writer.health(0, &health)
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}
