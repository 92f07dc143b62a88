//! Reader of one device: transport → driver → continuity → stamps → output.
//!
//! Inputs: bytes from a [`Transport`]. Outputs: readings to an [`Output`], and a [`Health`] report
//! ten times a second. One thread, no allocation per frame. A stop request takes effect within
//! [`READ_TIMEOUT`]; then the device is commanded to stop sending.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::failure::Failure;
use crate::intake::Intake;
use crate::reading::{Health, Output};
use crate::stamping::Stamper;
use crate::transport::{self, Input, READ_BYTES, Transport};
use crate::wire::{DeviceMessages, Driver, Interface};

/// Timeout of one read, and latency of a stop request. Design choice; signals interrupt the wait.
pub const READ_TIMEOUT: Duration = Duration::from_millis(50);
/// Acknowledgement timeout. Design choice: a hundred times the need at 1 MBd.
pub const ACKNOWLEDGEMENT_TIMEOUT: Duration = Duration::from_secs(1);
/// Time without data until a device is not alive. Design choice: ten frames of the slowest rate.
pub const ALIVE_TIMEOUT: Duration = Duration::from_secs(1);
/// Health report period (bus convention for sensors: about 10 Hz).
pub const REPORT_EVERY: Duration = Duration::from_millis(100);
/// Reports between two log lines about damage. Design choice: at most one line a second.
const REPORTS_PER_LOG: u32 = 10;
/// Reconnection period. Design choice.
const RETRY_EVERY: Duration = Duration::from_millis(500);
/// Answer timeout of a polled device. Design choice: ten times 171 bytes at 921,600 baud.
const ANSWER_TIMEOUT: Duration = Duration::from_millis(20);
/// Silence until an unanswered start command is repeated. Design choice.
const START_REPEAT_AFTER: Duration = Duration::from_millis(500);

/// Settings of one port.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Path or address.
    pub device: String,
    /// Type of transport.
    pub way: Interface,
    /// Nominal frame period, ns.
    pub period_ns: u64,
    /// True if commands may be sent to the device.
    pub configure: bool,
    /// True to subtract the mean of the first frames.
    pub tare: bool,
    /// True if the device may be a regular file (a recording).
    pub recording_allowed: bool,
    /// True to wait for a missing or lost device.
    pub reconnect: bool,
}

/// Reads the device until a stop request, the end of a recording, or a failure. Always sends a last
/// report.
///
/// # Errors
/// Every [`Failure`] except contradictory arguments.
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
    messages: DeviceMessages,
    intake: Intake,
    stamper: Stamper,
    health: Health,
    reported: Health,
    reports: u32,
    next_report_ns: u64,
    last_data_ns: u64,
    /// Time of the pending poll.
    polled_ns: Option<u64>,
    next_poll_ns: u64,
    next_start_ns: u64,
}

impl<'a> Port<'a> {
    fn new(
        settings: &'a Settings,
        driver: Box<dyn Driver>,
        output: &'a mut dyn Output,
        clock: fn() -> u64,
        stop: &'a AtomicBool,
    ) -> Self {
        let messages = if settings.configure {
            driver.messages()
        } else {
            DeviceMessages::default()
        };
        Self {
            settings,
            output,
            clock,
            stop,
            messages,
            intake: Intake::new(driver, settings.tare),
            stamper: Stamper::new(settings.period_ns),
            health: Health::default(),
            reported: Health::default(),
            reports: 0,
            next_report_ns: 0,
            last_data_ns: 0,
            polled_ns: None,
            next_poll_ns: 0,
            next_start_ns: 0,
        }
    }

    fn run(&mut self) -> Result<(), Failure> {
        loop {
            match self.connect_and_serve() {
                Err(failure) if self.settings.reconnect && failure.is_transient() => {
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
        self.intake.begin_stream(self.messages.acknowledged);
        self.send_start(device.as_mut())?;
        let once = std::mem::take(&mut self.messages.once);
        self.send_message(device.as_mut(), &once)?;
        let outcome = self.serve(device.as_mut());
        if !self.messages.stop.is_empty() && self.is_stopped() {
            // The device may already be disconnected.
            let _ = device.write(&self.messages.stop);
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
        if !device.accepts_messages() && self.messages != DeviceMessages::default() {
            return Err(refuse(
                "only a terminal can be configured; add --no-configure to read the stream as it is",
            ));
        }
        tracing::info!("reading {}", self.name());
        Ok(device)
    }

    fn serve(&mut self, device: &mut dyn Transport) -> Result<(), Failure> {
        let mut buffer = vec![0; READ_BYTES];
        let begun_ns = (self.clock)();
        self.polled_ns = None;
        while !self.is_stopped() {
            let patience = self.poll_when_due(device)?;
            let input = device.read(&mut buffer, patience);
            let now_ns = (self.clock)();
            match input {
                Input::Bytes(length) => self.take(&buffer[..length], now_ns)?,
                Input::Silence => self.repeat_start_when_due(device, now_ns)?,
                Input::End => return self.end_stream(now_ns),
                Input::Gone(error) => {
                    self.end_stream(now_ns)?;
                    return Err(Failure::Disconnected {
                        device: self.name(),
                        reason: error.to_string(),
                    });
                }
            }
            if self.is_answer_overdue(now_ns.saturating_sub(begun_ns)) {
                return Err(self.no_answer_failure());
            }
            self.report_when_due(now_ns)?;
        }
        self.end_stream((self.clock)())
    }

    fn send_message(&self, device: &mut dyn Transport, message: &[u8]) -> Result<(), Failure> {
        if message.is_empty() {
            return Ok(());
        }
        device
            .write(message)
            .map_err(|error| self.configure_failure(error.to_string()))
    }

    fn send_start(&mut self, device: &mut dyn Transport) -> Result<(), Failure> {
        self.next_start_ns = (self.clock)() + nanos(START_REPEAT_AFTER);
        self.send_message(device, &self.messages.start)
    }

    /// Polls the device when due; returns the next read timeout.
    fn poll_when_due(&mut self, device: &mut dyn Transport) -> Result<Duration, Failure> {
        if self.messages.poll.is_empty() || self.intake.awaits_acknowledgement() {
            return Ok(READ_TIMEOUT);
        }
        let now_ns = (self.clock)();
        if self
            .polled_ns
            .is_some_and(|at| now_ns >= at + nanos(ANSWER_TIMEOUT))
        {
            self.intake.count_unanswered();
            self.polled_ns = None;
        }
        if self.polled_ns.is_none() && now_ns >= self.next_poll_ns {
            self.send_message(device, &self.messages.poll)?;
            self.polled_ns = Some(now_ns);
            self.next_poll_ns = now_ns + self.settings.period_ns;
        }
        let due_ns = self
            .polled_ns
            .map_or(self.next_poll_ns, |at| at + nanos(ANSWER_TIMEOUT));
        Ok(Duration::from_nanos(due_ns.saturating_sub(now_ns)).min(READ_TIMEOUT))
    }

    /// Repeats the start command if a silent device may have missed it.
    fn repeat_start_when_due(
        &mut self,
        device: &mut dyn Transport,
        now_ns: u64,
    ) -> Result<(), Failure> {
        let silent_since_ns = self.last_data_ns + nanos(START_REPEAT_AFTER);
        if !self.messages.repeat_start || now_ns < self.next_start_ns.max(silent_since_ns) {
            return Ok(());
        }
        self.intake.expect_restart();
        self.send_start(device)
    }

    fn take(&mut self, bytes: &[u8], now_ns: u64) -> Result<(), Failure> {
        self.last_data_ns = now_ns;
        let frames = self.intake.health().bytes.frames;
        self.intake.push(bytes);
        if self.intake.health().bytes.frames > frames {
            self.polled_ns = None;
        }
        self.deliver(now_ns)
    }

    fn end_stream(&mut self, now_ns: u64) -> Result<(), Failure> {
        self.intake.finish();
        self.deliver(now_ns)
    }

    /// Stamps and outputs the pending readings.
    fn deliver(&mut self, now_ns: u64) -> Result<(), Failure> {
        if let Some(status) = self.intake.refusal() {
            return Err(self.configure_failure(format!(
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
        let alive = silent_ns < nanos(ALIVE_TIMEOUT);
        if self.health.alive && !alive {
            tracing::warn!("{} sends no data", self.name());
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
            std::thread::sleep(READ_TIMEOUT);
            self.report_when_due((self.clock)())?;
        }
        Ok(())
    }

    /// Returns whether the acknowledgement, or the first frame, is overdue.
    fn is_answer_overdue(&self, waited_ns: u64) -> bool {
        let asked = self.messages.repeat_start || !self.messages.poll.is_empty();
        let silent = asked && self.intake.health().bytes.frames == 0;
        self.intake.awaits_acknowledgement() && waited_ns > nanos(ACKNOWLEDGEMENT_TIMEOUT)
            || silent && waited_ns > 2 * nanos(ACKNOWLEDGEMENT_TIMEOUT)
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn name(&self) -> String {
        self.settings.device.clone()
    }

    fn configure_failure(&self, reason: String) -> Failure {
        Failure::Configure {
            device: self.name(),
            reason,
        }
    }

    fn no_answer_failure(&self) -> Failure {
        let bytes = self.intake.health().bytes;
        let (what, seconds) = if self.intake.awaits_acknowledgement() {
            ("acknowledgement", ACKNOWLEDGEMENT_TIMEOUT.as_secs())
        } else {
            ("frame", 2 * ACKNOWLEDGEMENT_TIMEOUT.as_secs())
        };
        self.configure_failure(format!(
            "no {what} within {seconds} s ({} bytes, {} valid frames received); check the sensor \
             type with `atas-sensor probe`, or add --no-configure to read a stream that cannot be \
             configured",
            bytes.received, bytes.frames,
        ))
    }
}

fn nanos(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}
