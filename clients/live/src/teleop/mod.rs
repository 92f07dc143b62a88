//! `atas teleop`: teleoperates a hand with the keyboard or a target file.
//!
//! ```text
//!  file (CSV, JSON lines) ─ timed targets ─┐
//!                                          ├─▶ TeleopSender ─ GraspTarget ─▶ daemon
//!  keys in a terminal ─ jog ───────────────┘
//! ```
//!
//! * **Invariants:** a file is validated completely before any motion. Time is the daemon's clock,
//!   also in lock-step. When the program ends, the stream ends: the hand brakes and keeps its grip.

mod file;
mod jog;
mod play;

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use atas_client::{POLL, Run, Session, TeleopHands, TeleopSender, json};
use atas_console::arguments::Teleop;
use atas_console::{Exit, ExitError, Interrupt, Output};
use shm_bus::Subscriber;
use shm_schemas::{EventKind, GoalState, ModuleEvent, service};

/// Longest wait for the daemon to start or end the goal. Design choice, as for every goal's end.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(1);
/// Validity of a target without a newer one, ns. Design choice: several times the delay on a busy
/// computer.
const VALID_NS: u64 = 400_000_000;

pub(crate) fn teleop(
    arguments: &Teleop,
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

/// Open target stream with the daemon's events.
struct Stream {
    leader: TeleopSender,
    events: Subscriber<ModuleEvent>,
    started_ns: u64,
    /// Number of fingertips of the hand; the larger one for two hands.
    fingertips: usize,
}

impl Stream {
    /// Opens the stream and waits until the daemon accepts it.
    fn open(session: &Session, teleoperated: TeleopHands) -> anyhow::Result<Self> {
        session.wait_until_armed(&AtomicBool::new(false))?;
        let (_, status) = session.watch_status()?;
        let fingers = Run::read(session.bus(), &status)?.fingertips(&status);
        let fingers = match teleoperated {
            TeleopHands::One(hand) => fingers[hand.index().unwrap_or(0)],
            TeleopHands::Both => fingers.into_iter().max().unwrap_or(0),
        };
        let mut leader = TeleopSender::open(session, teleoperated)?;
        let events = session.bus().subscriber(service::MODULE_EVENT)?;
        let begin = Instant::now();
        loop {
            let progress = *leader.poll()?;
            if leader.has_ended() {
                return Err(ExitError::with_code(Exit::Refused, progress.text()));
            }
            if progress.last().goal_id != 0 && leader.now_ns() != 0 {
                let begun_ns = leader.now_ns();
                return Ok(Self {
                    leader,
                    events,
                    started_ns: begun_ns,
                    fingertips: fingers,
                });
            }
            anyhow::ensure!(
                begin.elapsed() < ANSWER_TIMEOUT,
                "teleoperation not started: no answer from the daemon within {ANSWER_TIMEOUT:?}; see `atas \
                 status`"
            );
            std::thread::sleep(POLL);
        }
    }

    /// Polls the daemon; returns its warnings since the start of the stream.
    ///
    /// # Errors
    /// The goal has ended.
    fn poll(&mut self) -> anyhow::Result<Vec<String>> {
        self.leader.poll()?;
        let (begun_ns, mut warnings) = (self.started_ns, Vec::new());
        self.events.drain(usize::from(u8::MAX), |event| {
            if event.kind == EventKind::WARNING && event.stamp.captured_ns >= begun_ns {
                warnings.push(event.reason.to_string());
            }
        })?;
        if !self.leader.has_ended() {
            return Ok(warnings);
        }
        let progress = self.leader.poll()?;
        Err(ExitError::with_code(Exit::Refused, progress.text()))
    }

    /// Ends the stream and prints the result as text or JSON.
    fn end(mut self, sent: u64, interrupted: bool, output: &mut Output) -> anyhow::Result<()> {
        self.leader.end();
        let begin = Instant::now();
        while !self.leader.has_ended() {
            self.leader.poll()?;
            anyhow::ensure!(
                begin.elapsed() < ANSWER_TIMEOUT,
                "stream ended, but the daemon did not confirm it within {ANSWER_TIMEOUT:?}; see `atas \
                 status`, and run `atas estop` if in doubt"
            );
            std::thread::sleep(POLL);
        }
        let progress = *self.leader.poll()?;
        let last = progress.last();
        if output.is_json() {
            let mut value = json::goal(&progress, self.fingertips);
            value["targets"] = sent.into();
            output.json(&value)?;
        }
        if last.state != GoalState::CANCELLED {
            return Err(ExitError::with_code(Exit::Refused, progress.text()));
        }
        let keeps = if progress.presses() {
            "the hand keeps its grip"
        } else {
            "the hand stays where it is"
        };
        let took_s = self.leader.now_ns().saturating_sub(self.started_ns) as f64 * 1e-9;
        let sentence = format!("sent {sent} targets in {took_s:.1} s; {keeps}");
        if interrupted {
            return Err(ExitError::with_code(
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

/// Returns the number of targets in the text of a file, or all findings.
pub(crate) fn count_targets(text: &str) -> Result<usize, Vec<String>> {
    file::parse(text).map(|targets| targets.len())
}
