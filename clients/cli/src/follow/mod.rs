//! `atas follow`: leads a hand, by keys or by a file of targets.
//!
//! ```text
//!  file (CSV, JSON lines) ─ timed targets ─┐
//!                                          ├─▶ Leader ─ GraspTarget ─▶ daemon
//!  keys in a terminal ─ jog ───────────────┘
//! ```
//!
//! * **Invariants:** a file is checked whole before anything moves. Time is the daemon's, so that a file takes as long in
//!   lock-step. Whatever ends the program ends the stream: the hand brakes and keeps what it holds.

mod file;
mod jog;
mod play;

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use atas_client::{Leader, Led, POLL, Run, Session, json};
use atas_console::arguments::Follow;
use atas_console::{Ended, Exit, Interrupt, Output};
use shm_bus::Subscriber;
use shm_schemas::{EventKind, GoalState, ModuleEvent, service};

/// How long the daemon may take to take or to end the goal (ours: as for any goal's end).
const ANSWER: Duration = Duration::from_secs(1);
/// How long a target may be followed without a newer one, ns (ours: several times what a busy machine makes us late).
const VALID_NS: u64 = 400_000_000;

/// `atas follow`.
pub(crate) fn follow(
    arguments: &Follow,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    match &arguments.file {
        Some(file) => {
            let targets = file::read(file)?;
            play::play(&targets, &arguments.bus.bus, interrupt, output)
        }
        None => jog::jog(arguments, interrupt, output),
    }
}

/// A stream that the daemon has opened, and what it warns of.
struct Stream {
    leader: Leader,
    events: Subscriber<ModuleEvent>,
    begun_ns: u64,
    /// Fingers of the hand that is led, of two the greater number.
    fingers: usize,
}

impl Stream {
    /// Opens it, and waits until the daemon follows.
    fn open(session: &Session, led: Led) -> anyhow::Result<Self> {
        session.wait_until_armed(&AtomicBool::new(false))?;
        let (_, status) = session.watch_status()?;
        let fingers = Run::of(session.bus(), &status)?.fingers(&status);
        let fingers = match led {
            Led::One(hand) => fingers[hand.index().unwrap_or(0)],
            Led::Both => fingers.into_iter().max().unwrap_or(0),
        };
        let mut leader = Leader::open(session, led)?;
        let events = session.bus().subscriber(service::MODULE_EVENT)?;
        let begin = Instant::now();
        loop {
            let progress = *leader.look()?;
            if leader.ended() {
                return Err(Ended::with(Exit::Refused, progress.sentence()));
            }
            if progress.last().goal_id != 0 && leader.now_ns() != 0 {
                let begun_ns = leader.now_ns();
                return Ok(Self {
                    leader,
                    events,
                    begun_ns,
                    fingers,
                });
            }
            anyhow::ensure!(
                begin.elapsed() < ANSWER,
                "could not follow because the daemon did not answer within {ANSWER:?}; see `atas status`"
            );
            std::thread::sleep(POLL);
        }
    }

    /// Takes in what the daemon says: its warnings since this stream began, and an error if the goal has ended.
    fn look(&mut self) -> anyhow::Result<Vec<String>> {
        self.leader.look()?;
        let (begun_ns, mut warnings) = (self.begun_ns, Vec::new());
        self.events.drain(usize::from(u8::MAX), |event| {
            if event.kind == EventKind::WARNING && event.stamp.captured_ns >= begun_ns {
                warnings.push(event.reason.to_string());
            }
        })?;
        if !self.leader.ended() {
            return Ok(warnings);
        }
        let progress = self.leader.look()?;
        Err(Ended::with(Exit::Refused, progress.sentence()))
    }

    /// Ends it; the sentence about what became of it, or JSON.
    fn end(mut self, sent: u64, interrupted: bool, output: &mut Output) -> anyhow::Result<()> {
        self.leader.end();
        let begin = Instant::now();
        while !self.leader.ended() {
            self.leader.look()?;
            anyhow::ensure!(
                begin.elapsed() < ANSWER,
                "ended the stream, but the daemon did not confirm it within {ANSWER:?}; see `atas status`, and stop the robot \
                 with `atas estop` if in doubt"
            );
            std::thread::sleep(POLL);
        }
        let progress = *self.leader.look()?;
        let last = progress.last();
        if output.is_json() {
            let mut value = json::goal(&progress, self.fingers);
            value["targets"] = sent.into();
            output.json(&value)?;
        }
        if last.state != GoalState::CANCELLED {
            return Err(Ended::with(Exit::Refused, progress.sentence()));
        }
        let keeps = if progress.presses() {
            "the hand keeps what it has between its fingers"
        } else {
            "the hand stays where it is"
        };
        let took_s = self.leader.now_ns().saturating_sub(self.begun_ns) as f64 * 1e-9;
        let sentence = format!("followed {sent} targets in {took_s:.1} s; {keeps}");
        if interrupted {
            return Err(Ended::with(
                Exit::Interrupted,
                format!("interrupted: {sentence}"),
            ));
        }
        if output.is_json() {
            return Ok(());
        }
        output.line(sentence)
    }
}
