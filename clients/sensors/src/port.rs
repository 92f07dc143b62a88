//! One device on its port: transport → driver → continuity → stamps → output.
//!
//! In: bytes from a [`Transport`]. Out: readings to an [`Output`], as they come, and a [`Health`] report ten times a
//! second. One thread, no allocation per frame. A stop request ends it within [`POLL`]; the device is then told to stop
//! sending.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::failure::Failure;
use crate::intake::Intake;
use crate::reading::{Health, Output};
use crate::stamping::Stamper;
use crate::transport::{self, Input, READ_BYTES, Transport};
use crate::wire::{Dialogue, Driver, Way};

/// How long one read waits, and so how soon a stop request is seen. Ours; signals also interrupt the wait.
pub const POLL: Duration = Duration::from_millis(50);
/// How long the device may take to acknowledge. Ours: a hundred times what a device needs at 1 MBd.
pub const ACKNOWLEDGE_WITHIN: Duration = Duration::from_secs(1);
/// A device that sends nothing for so long is reported as not alive. Ours: ten frames of the slowest rate.
pub const SILENCE: Duration = Duration::from_secs(1);
/// Time between two health reports (bus convention for sensors: about 10 Hz).
pub const REPORT_EVERY: Duration = Duration::from_millis(100);
/// Reports between two log lines about damage. Ours: at most one line a second.
const REPORTS_PER_LOG: u32 = 10;
/// Time between two attempts to reconnect. Ours.
const RETRY_EVERY: Duration = Duration::from_millis(500);
/// How long a polled device may take to answer. Ours: ten times what 171 bytes take at 921,600 baud.
const ANSWER_WITHIN: Duration = Duration::from_millis(20);
/// Silence after which a device that may have missed its start is told again. Ours.
const INSIST_AFTER: Duration = Duration::from_millis(500);

/// What to run.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Path or address of the device.
    pub device: String,
    /// How it is reached.
    pub way: Way,
    /// Nominal time between two frames, ns.
    pub period_ns: u64,
    /// Whether the device may be told anything.
    pub configure: bool,
    /// Whether the mean of the first frames is subtracted.
    pub tare: bool,
    /// Whether a regular file may be decoded.
    pub recording_allowed: bool,
    /// Whether to wait for a device that is missing or goes away.
    pub reconnect: bool,
}

/// Runs until a stop request, the end of a recording, or a failure. The last report is sent in every case.
///
/// # Errors
/// Everything that [`Failure`] names except contradictory arguments.
pub fn run(
    settings: &Settings,
    driver: Box<dyn Driver>,
    output: &mut dyn Output,
    clock: fn() -> u64,
    stop: &AtomicBool,
) -> (Health, Result<(), Failure>) {
    let mut port = Port::new(settings, driver, output, clock, stop);
    let outcome = port.run();
    let goodbye = port.report(false);
    (port.health, outcome.and(goodbye))
}

struct Port<'a> {
    settings: &'a Settings,
    output: &'a mut dyn Output,
    clock: fn() -> u64,
    stop: &'a AtomicBool,
    dialogue: Dialogue,
    intake: Intake,
    stamper: Stamper,
    health: Health,
    reported: Health,
    reports: u32,
    next_report_ns: u64,
    last_data_ns: u64,
    /// When the device was asked for the frame that has not come yet.
    asked_ns: Option<u64>,
    next_ask_ns: u64,
    next_insist_ns: u64,
}

impl<'a> Port<'a> {
    fn new(
        settings: &'a Settings,
        driver: Box<dyn Driver>,
        output: &'a mut dyn Output,
        clock: fn() -> u64,
        stop: &'a AtomicBool,
    ) -> Self {
        let dialogue = if settings.configure {
            driver.dialogue()
        } else {
            Dialogue::default()
        };
        Self {
            settings,
            output,
            clock,
            stop,
            dialogue,
            intake: Intake::new(driver, settings.tare),
            stamper: Stamper::new(settings.period_ns),
            health: Health::default(),
            reported: Health::default(),
            reports: 0,
            next_report_ns: 0,
            last_data_ns: 0,
            asked_ns: None,
            next_ask_ns: 0,
            next_insist_ns: 0,
        }
    }

    fn run(&mut self) -> Result<(), Failure> {
        loop {
            match self.connect_and_serve() {
                Err(failure) if self.settings.reconnect && failure.may_pass() => {
                    tracing::warn!("{failure}; trying again");
                    self.wait_for_retry()?;
                }
                outcome => return outcome,
            }
            if self.is_stopped() {
                return Ok(());
            }
        }
    }

    fn connect_and_serve(&mut self) -> Result<(), Failure> {
        let mut device = self.open()?;
        self.intake.begin_stream(self.dialogue.acknowledged);
        self.say_start(device.as_mut())?;
        let once = std::mem::take(&mut self.dialogue.once);
        self.say(device.as_mut(), &once)?;
        let outcome = self.serve(device.as_mut());
        if !self.dialogue.stop.is_empty() && self.is_stopped() {
            // The device may be gone already; that is no reason not to stop.
            let _ = device.write(&self.dialogue.stop);
        }
        outcome
    }

    fn open(&self) -> Result<Box<dyn Transport>, Failure> {
        let refuse = |reason: &str| Failure::Open {
            device: self.name(),
            reason: reason.to_owned(),
        };
        let device = transport::open(self.settings.way, &self.settings.device)
            .map_err(|reason| refuse(&reason))?;
        if device.is_recording() && !self.settings.recording_allowed {
            return Err(refuse(
                "it is a regular file, needs a terminal or a FIFO; add --dry-run to decode a recording",
            ));
        }
        if !device.takes_messages() && self.dialogue != Dialogue::default() {
            return Err(refuse(
                "only a terminal can be configured; add --no-configure to read the stream as it is",
            ));
        }
        tracing::info!("reading {}", self.name());
        Ok(device)
    }

    /// Reads until a stop request, the end or a failure.
    fn serve(&mut self, device: &mut dyn Transport) -> Result<(), Failure> {
        let mut buffer = vec![0; READ_BYTES];
        let begun_ns = (self.clock)();
        self.asked_ns = None;
        while !self.is_stopped() {
            let patience = self.ask_when_due(device)?;
            let input = device.read(&mut buffer, patience);
            let now_ns = (self.clock)();
            match input {
                Input::Bytes(length) => self.take(&buffer[..length], now_ns)?,
                Input::Quiet => self.insist_when_due(device, now_ns)?,
                Input::End => return self.end_stream(now_ns),
                Input::Gone(error) => {
                    self.end_stream(now_ns)?;
                    return Err(Failure::Gone {
                        device: self.name(),
                        reason: error.to_string(),
                    });
                }
            }
            if self.is_unanswered(now_ns.saturating_sub(begun_ns)) {
                return Err(self.unanswered());
            }
            self.report_when_due(now_ns)?;
        }
        self.end_stream((self.clock)())
    }

    fn say(&self, device: &mut dyn Transport, message: &[u8]) -> Result<(), Failure> {
        if message.is_empty() {
            return Ok(());
        }
        device
            .write(message)
            .map_err(|error| self.unconfigured(error.to_string()))
    }

    fn say_start(&mut self, device: &mut dyn Transport) -> Result<(), Failure> {
        self.next_insist_ns = (self.clock)() + nanos(INSIST_AFTER);
        self.say(device, &self.dialogue.start)
    }

    /// Asks a polled device for its next frame, and says how long to wait for something to come.
    fn ask_when_due(&mut self, device: &mut dyn Transport) -> Result<Duration, Failure> {
        if self.dialogue.poll.is_empty() || self.intake.awaits_acknowledgement() {
            return Ok(POLL);
        }
        let now_ns = (self.clock)();
        if self
            .asked_ns
            .is_some_and(|at| now_ns >= at + nanos(ANSWER_WITHIN))
        {
            self.intake.miss();
            self.asked_ns = None;
        }
        if self.asked_ns.is_none() && now_ns >= self.next_ask_ns {
            self.say(device, &self.dialogue.poll)?;
            self.asked_ns = Some(now_ns);
            self.next_ask_ns = now_ns + self.settings.period_ns;
        }
        let due_ns = self
            .asked_ns
            .map_or(self.next_ask_ns, |at| at + nanos(ANSWER_WITHIN));
        Ok(Duration::from_nanos(due_ns.saturating_sub(now_ns)).min(POLL))
    }

    /// Tells a silent device again to begin, if it may have missed it.
    fn insist_when_due(&mut self, device: &mut dyn Transport, now_ns: u64) -> Result<(), Failure> {
        let silent_since_ns = self.last_data_ns + nanos(INSIST_AFTER);
        if !self.dialogue.insist || now_ns < self.next_insist_ns.max(silent_since_ns) {
            return Ok(());
        }
        self.intake.begin_anew();
        self.say_start(device)
    }

    fn take(&mut self, bytes: &[u8], now_ns: u64) -> Result<(), Failure> {
        self.last_data_ns = now_ns;
        let frames = self.intake.health().bytes.frames;
        self.intake.push(bytes);
        if self.intake.health().bytes.frames > frames {
            self.asked_ns = None;
        }
        self.deliver(now_ns)
    }

    fn end_stream(&mut self, now_ns: u64) -> Result<(), Failure> {
        self.intake.finish();
        self.deliver(now_ns)
    }

    /// Stamps and hands on what the intake gathered.
    fn deliver(&mut self, now_ns: u64) -> Result<(), Failure> {
        if let Some(status) = self.intake.refusal() {
            return Err(self.unconfigured(format!(
                "it refused with status {status}; check rate and filter"
            )));
        }
        if let Some(found) = self.intake.foreign() {
            return Err(Failure::WrongKind {
                device: self.name(),
                found,
            });
        }
        let stamps = self.stamper.spread(now_ns, self.intake.batch.len());
        for (reading, captured_ns) in self.intake.batch.readings.iter_mut().zip(stamps) {
            reading.captured_ns = captured_ns;
        }
        self.output.readings(&self.intake.batch)?;
        self.intake.batch.clear();
        Ok(())
    }

    fn report_when_due(&mut self, now_ns: u64) -> Result<(), Failure> {
        if now_ns < self.next_report_ns {
            return Ok(());
        }
        self.next_report_ns = now_ns + nanos(REPORT_EVERY);
        let silent_ns = now_ns.saturating_sub(self.last_data_ns);
        let alive = silent_ns < nanos(SILENCE);
        if self.health.alive && !alive {
            tracing::warn!("{} is silent", self.name());
        }
        self.report(alive)
    }

    fn report(&mut self, alive: bool) -> Result<(), Failure> {
        self.health = Health {
            alive,
            ..self.intake.health()
        };
        self.reports += 1;
        if self.reports.is_multiple_of(REPORTS_PER_LOG) && self.health.is_worse_than(&self.reported)
        {
            tracing::warn!("{}: {}", self.name(), self.health);
            self.reported = self.health;
        }
        self.output.health(&self.health)
    }

    fn wait_for_retry(&mut self) -> Result<(), Failure> {
        let until_ns = (self.clock)() + nanos(RETRY_EVERY);
        while (self.clock)() < until_ns && !self.is_stopped() {
            std::thread::sleep(POLL);
            self.report_when_due((self.clock)())?;
        }
        Ok(())
    }

    /// Whether a device that should have answered by now did not: no acknowledgement, or no frame at all.
    fn is_unanswered(&self, waited_ns: u64) -> bool {
        let asked = self.dialogue.insist || !self.dialogue.poll.is_empty();
        let silent = asked && self.intake.health().bytes.frames == 0;
        self.intake.awaits_acknowledgement() && waited_ns > nanos(ACKNOWLEDGE_WITHIN)
            || silent && waited_ns > 2 * nanos(ACKNOWLEDGE_WITHIN)
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn name(&self) -> String {
        self.settings.device.clone()
    }

    fn unconfigured(&self, reason: String) -> Failure {
        Failure::Configure {
            device: self.name(),
            reason,
        }
    }

    fn unanswered(&self) -> Failure {
        let bytes = self.intake.health().bytes;
        let (what, seconds) = if self.intake.awaits_acknowledgement() {
            ("acknowledgement", ACKNOWLEDGE_WITHIN.as_secs())
        } else {
            ("frame", 2 * ACKNOWLEDGE_WITHIN.as_secs())
        };
        self.unconfigured(format!(
            "no {what} within {seconds} s, {} bytes and {} valid frames came; check that it is such a sensor \
             (atas-sensor probe), or add --no-configure to read a stream that cannot be configured",
            bytes.received, bytes.frames,
        ))
    }
}

fn nanos(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}
