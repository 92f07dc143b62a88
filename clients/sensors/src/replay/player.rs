//! Plays frames: each at its time, with a stamp of now.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::Duration;

use shm_bus::{BusName, now_ns};
use shm_schemas::{HandFrame, Stamp};

use super::{Frames, Pace, Source, Timeline};
use crate::failure::Failure;
use crate::port::{POLL, REPORT_EVERY};
use crate::reading::Health;
use crate::writer::{BURST, BURST_PAUSE, HandWriter};

/// Frames that are read ahead (ours: half a second at 1 kHz, longer than unpacking a piece of a recording takes).
const AHEAD: usize = 512;
/// How far behind its time a frame may be before time is shifted for all that follow, ns. Ours: as much as a reader of the bus
/// buffers at 1 kHz.
const BEHIND_NS: u64 = 50_000_000;

/// What was played.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Played {
    /// Frames.
    pub frames: u64,
    /// Frames that were lost when it was recorded.
    pub lost: u64,
    /// Recorded frames that were left out: damaged, or not newer than all before.
    pub left_out: u64,
    /// How often this machine did not keep up.
    pub delays: u64,
}

impl fmt::Display for Played {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            frames,
            lost,
            left_out,
            delays,
        } = self;
        write!(
            f,
            "{frames} frames played, {lost} lost when recorded, {left_out} left out, {delays} delays"
        )
    }
}

/// Plays to the end, round after round with `again`, or until a stop request. What was played is known in every case.
///
/// # Errors
/// [`Failure::Recording`] or [`Failure::Usage`] before anything is played, [`Failure::Torn`] at damage, [`Failure::Bus`].
pub fn play(
    source: &Source,
    pace: Pace,
    again: bool,
    bus: &BusName,
    stop: &AtomicBool,
) -> (Played, Result<(), Failure>) {
    let opened = source.check().and_then(|()| {
        let name = source.name();
        HandWriter::open(bus, source.hand, [("replay", &*name)].into_iter())
    });
    let writer = match opened {
        Ok(writer) => writer,
        Err(failure) => return (Played::default(), Err(failure)),
    };
    let mut player = Player {
        writer,
        timeline: Timeline::new(pace),
        source,
        stop,
        played: Played::default(),
        next_sequence: 0,
        due_ns: now_ns(),
        at_once: 0,
        next_report_ns: 0,
    };
    let outcome = thread::scope(|scope| {
        let (to, from) = sync_channel(AHEAD);
        scope.spawn(move || read(source, again, &to));
        // It owns the receiving end: when it ends, the reader does.
        player.run(from)
    });
    let goodbye = player.report(false);
    (player.played, outcome.and(goodbye))
}

/// What the reading thread hands over.
enum Parcel {
    Frame(Box<HandFrame>),
    NextRound,
    Failure(Failure),
}

/// Reads until the end, or until nobody listens.
fn read(source: &Source, again: bool, to: &SyncSender<Parcel>) {
    loop {
        let failure = match source.frames() {
            Ok(frames) => match read_round(frames, to) {
                Ok(()) if !again => return,
                Ok(()) => None,
                Err(reason) => Some(Failure::Torn(reason)),
            },
            Err(failure) => Some(failure),
        };
        let is_over = failure.is_some();
        let parcel = failure.map_or(Parcel::NextRound, Parcel::Failure);
        if to.send(parcel).is_err() || is_over {
            return;
        }
    }
}

fn read_round(frames: Frames, to: &SyncSender<Parcel>) -> Result<(), String> {
    for frame in frames {
        if to.send(Parcel::Frame(Box::new(frame?))).is_err() {
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
    played: Played,
    next_sequence: u64,
    /// When the last frame was due.
    due_ns: u64,
    /// Frames since the last pause.
    at_once: usize,
    next_report_ns: u64,
}

impl Player<'_> {
    fn run(&mut self, from: Receiver<Parcel>) -> Result<(), Failure> {
        self.report_when_due(now_ns())?;
        while !self.is_stopped() {
            match from.recv_timeout(POLL) {
                Ok(Parcel::Frame(frame)) => self.take(*frame)?,
                Ok(Parcel::NextRound) => self.timeline.begin_round(),
                Ok(Parcel::Failure(failure)) => return Err(failure),
                Err(RecvTimeoutError::Timeout) => self.report_when_due(now_ns())?,
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        Ok(())
    }

    fn take(&mut self, mut frame: HandFrame) -> Result<(), Failure> {
        let step = Some(frame.stamp).filter(|_| frame.is_intact());
        let Some(step) = step.and_then(|stamp| self.timeline.take(stamp)) else {
            self.played.left_out += 1;
            return Ok(());
        };
        self.due_ns += step.after_ns;
        if !self.wait()? {
            return Ok(());
        }
        self.next_sequence += step.advance;
        frame.hand = self.source.hand;
        frame.stamp = Stamp {
            writer_epoch: self.writer.epoch(),
            sequence: self.next_sequence - 1,
            captured_ns: self.due_ns,
        };
        frame.seal();
        self.writer.frame(&frame)?;
        self.played.frames += 1;
        self.played.lost += step.advance - 1;
        Ok(())
    }

    /// Waits until the frame is due; false if it is not to be played any more.
    fn wait(&mut self) -> Result<bool, Failure> {
        while !self.is_stopped() {
            let now_ns = now_ns();
            self.report_when_due(now_ns)?;
            if now_ns >= self.due_ns {
                self.catch_up(now_ns);
                return Ok(true);
            }
            thread::sleep(Duration::from_nanos(self.due_ns - now_ns).min(POLL));
            self.at_once = 0;
        }
        Ok(false)
    }

    /// A frame that is late goes out at once, but not so many that a reader is overrun, and not with a stamp of long ago.
    fn catch_up(&mut self, now_ns: u64) {
        self.at_once += 1;
        if self.at_once.is_multiple_of(BURST) {
            thread::sleep(BURST_PAUSE);
        }
        if now_ns - self.due_ns > BEHIND_NS {
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
